/// Solves a sliding window stored as text: ch5_window FILE --out DIR.

#include <cstdio>
#include <filesystem>

#include "ch5_backend/evaluate/trajectory_error.h"
#include "ch5_backend/experiments/studies/file_command.h"
#include "ch5_backend/experiments/studies/window_graph.h"
#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/tables/trajectory_file.h"

namespace {

using namespace ch5;

constexpr char kUsage[] =
    "usage: ch5_window FILE --out DIR [--iterations N] [--threads N] [--solver NAME] [--landmark-steps N]\n"
    "Solves the window of a visual-inertial estimator in FILE (VIOWIN text) and writes into DIR: its frames before "
    "and\n"
    "after, the table of iterations, a summary, and what figures/window.py draws.\n"
    "  --iterations N   at most N iterations (50)\n"
    "  --threads N      (as many as the machine has); the result does not depend on it\n"
    "  --solver NAME    dense, sparse, pcg, implicit-pcg, power-series, or automatic (the default): dense or sparse\n"
    "  --landmark-steps N  after each step, so many of each landmark alone (0)\n";

std::vector<StampedState> StatesOf(const WindowDump& dump, const WindowGraph& window) {
  std::vector<StampedState> states = dump.frames;
  for (size_t k = 0; k < states.size(); ++k) {
    states[k].T_W_B = {window.poses[k]->q(), window.poses[k]->p()};
    if (window.speed_biases.empty()) continue;
    states[k].v_W = window.speed_biases[k]->v();
    states[k].b_a = window.speed_biases[k]->b_a();
    states[k].b_g = window.speed_biases[k]->b_g();
  }
  return states;
}

CsvTable FrameTable(const WindowDump& dump, const std::vector<StampedState>& after) {
  CsvTable table("state,frame,t_s,x_m,y_m,z_m");
  const auto append = [&](const char* name, const std::vector<StampedState>& states) {
    for (size_t k = 0; k < states.size(); ++k) {
      const Vec3& p = states[k].T_W_B.p;
      table.Row(name, k, states[k].t, p.x(), p.y(), p.z());
    }
  };
  append("before", dump.frames);
  append("after", after);
  append("truth", dump.truth);
  return table;
}

CsvTable SummaryOf(const Summary& summary, const WindowDump& dump, const FileSolveOptions& options) {
  CsvTable table = SummaryTable(summary, options);
  table.Row("frames", dump.frames.size());
  table.Row("landmarks", dump.landmarks.size());
  table.Row("prior_rows", dump.prior_r.size());
  return table;
}

void Run(const FileSolveOptions& options) {
  const std::filesystem::path out = options.out;
  const std::string name = options.Name();
  const WindowDump dump = ReadWindowDump(options.input);
  WindowGraph window = BuildWindowGraph(dump);
  const OutputFolder made(out);
  std::printf("%s: %zu frames, %zu landmarks, a prior of %td rows\n\n", name.c_str(), dump.frames.size(),
              dump.landmarks.size(), dump.prior_r.size());
  const Summary summary = SolveGraph(&window.graph, options);

  const std::vector<StampedState> after = StatesOf(dump, window);
  FileBatch files(options.input);
  files.Add(out / "frames.csv", FrameTable(dump, after).Text());
  files.Add(out / (name + "-result.tum"), FormatTum(after, 0));
  files.Add(out / "trace.csv", TraceTable(summary).Text());
  files.Add(out / "summary.csv", SummaryOf(summary, dump, options).Text());
  files.Commit();
  PrintSummary(summary);
}

}  // namespace

int main(int argc, char** argv) {
  FileSolveOptions options;
  options.solve.cost_tolerance = 1e-9;
  options.solve.algorithm = Algorithm::kDogleg;
  return RunFileCommand("ch5_window", kUsage, argc, argv, &options, [&] { Run(options); });
}
