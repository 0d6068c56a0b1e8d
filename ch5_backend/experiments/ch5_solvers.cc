/// The second lecture's experiments with solvers, as tables: ch5_solvers [--out DIR] writes DIR/csv/solver_*.csv.

#include <filesystem>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/solver/solver_studies.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_solvers [--out DIR]\n"
    "Compares preconditioners, rules for the damping, kinds of step and robust losses on simulated scenes, and writes\n"
    "their tables to DIR/csv (DIR is out/ unless given).\n";

void RunStudies(const std::filesystem::path& csv) {
  const ch5::Progress progress;
  progress.Show("conjugate gradients", 0.0);
  ch5::RunPcgStudy(csv);
  progress.Show("damping", 0.25);
  ch5::RunDampingStudy(csv);
  progress.Show("steps", 0.5);
  ch5::RunStepStudy(csv);
  progress.Show("losses", 0.75);
  ch5::RunLossStudy(csv);
}

}  // namespace

int main(int argc, char** argv) {
  std::string out = "out";
  ch5::CommandLine line("ch5_solvers", kUsage);
  line.Text("--out", &out);
  return line.Run(argc, argv, [&] { RunStudies(std::filesystem::path(out) / "csv"); });
}
