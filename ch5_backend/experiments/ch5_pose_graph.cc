/// Optimizes a pose graph: ch5_pose_graph FILE.g2o --out DIR.

#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "ch5_backend/experiments/studies/file_command.h"
#include "ch5_backend/experiments/studies/pose_graph_study.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_pose_graph FILE --out DIR [--iterations N] [--threads N] [--huber X] [--solver NAME]\n"
    "Optimizes the pose graph in FILE (g2o's text format, SE2 and SE3) and writes into DIR: the result as .g2o, the\n"
    "table of iterations, a summary, and what figures/pose_graph.py draws. The first pose is held if the file fixes "
    "none.\n"
    "  --iterations N   at most N iterations (50)\n"
    "  --threads N      (as many as the machine has); the result does not depend on it\n"
    "  --huber X        Huber's loss on each edge's normalized error with this threshold (none)\n"
    "  --solver NAME    dense, sparse, pcg, implicit-pcg, power-series, or automatic (the default): dense or sparse\n";

void PrintUnknown(const ch5::G2oFile& graph, const std::string& file) {
  constexpr size_t kMost = 5;
  for (size_t k = 0; k < graph.unknown.size() && k < kMost; ++k) {
    const ch5::G2oFile::Line& line = graph.unknown[k];
    std::printf("%s:%d: unknown, kept as it is: %.60s\n", file.c_str(), line.number, line.text.c_str());
  }
  if (graph.unknown.size() > kMost) std::printf("… and %zu more\n", graph.unknown.size() - kMost);
}

void Run(const ch5::FileCommand& command) {
  const std::string name = command.Name();
  ch5::G2oFile graph = ch5::ReadG2o(command.file);
  if (graph.graph.Edges().empty()) throw std::invalid_argument("no edge of a known type, so nothing to optimize");
  std::filesystem::create_directories(command.out);
  PrintUnknown(graph, command.file);
  std::printf("%s: %zu poses, %zu edges\n\n", name.c_str(), graph.ids.size(), graph.graph.Edges().size());

  ch5::IterationTable table;
  const ch5::PoseGraphStudy study =
      ch5::SolvePoseGraph(command.options, &graph, [&](const ch5::IterationInfo& info) { table.Print(info); });
  ch5::WritePoseGraphStudy(study, graph, command.options, name, command.out);
  for (const int id : study.fixed_ids) std::printf("pose %d was held: the file fixes none of its part\n", id);
  ch5::PrintSummary(study.summary);
}

}  // namespace

int main(int argc, char** argv) { return ch5::RunFileCommand("ch5_pose_graph", kUsage, argc, argv, Run); }
