/// Optimizes a pose graph: ch5_pose_graph FILE.g2o --out DIR.

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "ch5_backend/experiments/studies/graph_doubts.h"
#include "ch5_backend/files/tables/text_writer.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_pose_graph FILE --out DIR [--init START] [--iterations N] [--threads N] [--huber X] [--solver NAME]\n"
    "                      [--incremental N] [--loss NAME] [--scale X] [--gnc] [--project-information] [--leave-out]\n"
    "Optimizes the pose graph in FILE (g2o's text format, slam2d and slam3d) and writes into DIR: the result as\n"
    ".g2o, the table of iterations, a summary, and what figures/pose_graph.py draws. The first pose is held if\n"
    "nothing in the file holds it.\n"
    "  --init START     where it begins: file (the file's poses), odometry (along the path), spanning-tree (along\n"
    "                   the tree with the fewest edges), chordal (chordal relaxation), or incremental (pose after\n"
    "                   pose, solved in between; by itself if there are landmarks); unless given, the one of least\n"
    "                   cost\n"
    "  --incremental N  first solves the graph as a robot does, while it grows: an update after every N poses, which\n"
    "                   does again only what changes (iSAM2), and prints what that took; then as without\n"
    "  --iterations N   at most N iterations (1000)\n"
    "  --threads N      (as many as the machine has); the result does not depend on it\n"
    "  --huber X        Huber's loss on each edge's normalized error with this threshold (none)\n"
    "  --loss NAME      a loss on the edges that close loops: huber, cauchy, geman-mcclure, dcs or tls (none)\n"
    "  --scale X        of --loss and --gnc: a loop is good up to this normalized error (from the chi-squared\n"
    "                   distribution: no good loop of the file is beyond it, with probability 0.99)\n"
    "  --gnc            finds false loops by graduated non-convexity, from odometry, and gives them up: given_up.csv;\n"
    "                   towards truncated least squares, or with --loss geman-mcclure towards that\n"
    "  --solver NAME    dense, sparse, pcg, implicit-pcg, power-series, or automatic (the default): dense or sparse\n"
    "  --project-information\n"
    "                   replaces each information matrix that is not positive semi-definite by the nearest one\n"
    "                   that is\n"
    "  --leave-out      leaves out lines whose tag is not known, which are an error otherwise\n";

void PrintUnknown(const ch5::G2oFile& graph, const std::string& file) {
  if (graph.unknown.empty()) return;
  constexpr size_t kMost = 5;
  std::printf("%zu lines left out, since their tags are not known:\n", graph.unknown.size());
  for (size_t k = 0; k < graph.unknown.size() && k < kMost; ++k) {
    const ch5::G2oFile::Line& line = graph.unknown[k];
    std::printf("%s:%d: %.60s\n", file.c_str(), line.number, line.text.c_str());
  }
  if (graph.unknown.size() > kMost) std::printf("… and %zu more\n", graph.unknown.size() - kMost);
}

// What was read otherwise than it is written.
void PrintDoubtsOfReading(const ch5::G2oFile& graph) {
  if (graph.lists) {
    std::printf("the last numbers of ODOMETRY and LANDMARK were taken for %s, by their size\n",
                *graph.lists == ch5::G2oFile::Lists::kRoots ? "square roots of information" : "covariances");
  }
  if (graph.repeated > 0) {
    std::printf("edges given twice with the same numbers, and counted twice: %d, the first in line %d\n",
                graph.repeated, graph.first_repeated);
  }
  if (graph.repeated_vertices > 0) {
    std::printf("vertices given twice with the same numbers, and counted once: %d, the first in line %d\n",
                graph.repeated_vertices, graph.first_repeated_vertex);
  }
  if (!graph.unended.empty()) std::printf("%s\n", graph.unended.c_str());
  if (graph.projected > 0) {
    std::printf("%d information matrices were not positive semi-definite, and were projected\n", graph.projected);
  }
}

void PrintStart(const ch5::PoseGraphStudy& study) {
  std::fputs(study.growth.c_str(), stdout);
  std::printf("start: %s;", ch5::NameOf(study.start).c_str());
  for (const auto& [start, cost] : study.costs_of_starts) std::printf("  %s %.6e", ch5::NameOf(start).c_str(), cost);
  std::printf("  (%.3f s)\n\n", study.seconds_to_start);
}

void PrintAlone(const std::vector<int64_t>& ids) {
  if (ids.empty()) return;
  constexpr size_t kMost = 5;
  std::string first;
  for (size_t k = 0; k < ids.size() && k < kMost; ++k) first += " " + std::to_string(ids[k]);
  std::printf("poses and landmarks without an edge, which stay where the file has them: %zu, with the ids%s%s\n",
              ids.size(), first.c_str(), ids.size() > kMost ? " …" : "");
}

// Options that contradict each other.
void Check(const ch5::PoseGraphOptions& options) {
  if (options.loss && options.huber > 0.0) throw std::invalid_argument("--huber and --loss are two losses; give one");
  if (options.gnc && options.huber > 0.0) throw std::invalid_argument("--huber does not go with --gnc");
  if (options.gnc && options.loss && *options.loss != ch5::LoopLoss::kTruncated &&
      *options.loss != ch5::LoopLoss::kGemanMcClure)
    throw std::invalid_argument("--gnc goes with --loss tls or geman-mcclure only");
  if (options.scale > 0.0 && !options.loss && !options.gnc)
    throw std::invalid_argument("--scale needs --loss or --gnc");
  if (options.incremental > 0 && (options.start || options.gnc))
    throw std::invalid_argument("--incremental is a start of its own: it does not go with --init or --gnc");
}

void Run(const ch5::PoseGraphOptions& options, const ch5::G2oOptions& reading) {
  Check(options);
  ch5::G2oFile graph = ch5::ReadG2o(options.input, reading);
  const auto& edges = graph.graph.Edges();
  if (edges.empty()) throw std::invalid_argument("no edge of a known type, so nothing to optimize");
  if (std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge->Information().isZero(0.0); }))
    throw std::invalid_argument("the information matrices of all edges are zero, so nothing to optimize");
  const ch5::OutputFolder made(options.out);
  PrintUnknown(graph, options.input);
  const size_t landmarks = ch5::CountLandmarks(graph);
  std::printf("%s: %zu poses, %zu landmarks, %zu edges\n", options.Name().c_str(), graph.ids.size() - landmarks,
              landmarks, edges.size());
  PrintDoubtsOfReading(graph);

  if (!graph.has_poses) ch5::InitializeAtLeastCost({ch5::PoseGraphStart::kOdometry}, &graph.graph, options.threads);
  std::string doubts = ch5::DoubtsOfMeasurements(graph);
  ch5::PoseGraphStudy study = ch5::StartPoseGraph(options, &graph);
  PrintAlone(study.alone_ids);
  PrintStart(study);
  ch5::SolveStartedPoseGraph(options, &graph.graph, &study);
  if (doubts.empty()) doubts = ch5::DoubtsOfMeasurements(graph);
  if (doubts.empty()) {
    doubts = ch5::DoubtOfInformation(graph.graph);
    if (!doubts.empty() && !options.gnc && ch5::AreSomeLoopsFalse(options, reading)) doubts.clear();
  }
  study.doubts = doubts = ch5::DoubtOfZeroInformation(graph) + doubts;
  ch5::WritePoseGraphStudy(study, graph, options);
  for (const int64_t id : study.fixed_ids) {
    std::printf("pose %s was held: nothing in the file holds its part\n", std::to_string(id).c_str());
  }
  const auto& vertices = graph.graph.Vertices();
  if (std::all_of(vertices.begin(), vertices.end(), [](const auto& vertex) { return vertex->IsFixed(); }))
    std::printf("the file holds every pose, so nothing moves\n");
  ch5::PrintSummary(study.summary);
  std::fputs(doubts.c_str(), stdout);
  std::string said = ch5::ReportOnLoops(options, study, graph);
  if (said.empty() && !options.loss) said = ch5::HintAtHuber(graph.graph, options);
  if (!said.empty()) std::printf("%s\n", said.c_str());
}

}  // namespace

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): RunFileCommand catches
  ch5::PoseGraphOptions options;
  ch5::G2oOptions reading;
  const auto run = [&] { Run(options, reading); };
  return ch5::RunFileCommand("ch5_pose_graph", kUsage, argc, argv, &options, run, [&](ch5::CommandLine* line) {
    line->Option("--init",
                 [&](const std::string& word) { options.start = ch5::OneOf(word, ch5::kPoseGraphStartNames); });
    line->Option("--loss", [&](const std::string& word) { options.loss = ch5::OneOf(word, ch5::kLoopLossNames); });
    line->Number("--scale", 1e-6, 1e6, &options.scale);
    line->Number("--incremental", 1, 1000000, &options.incremental);
    line->Flag("--gnc", [&] { options.gnc = true; });
    line->Flag("--project-information", [&] { reading.project_information = true; });
    line->Flag("--leave-out", [&] { reading.leave_out = true; });
  });
}
