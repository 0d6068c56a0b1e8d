/// Is the window as certain as it has a right to be? ch5_nees [--out DIR] [--runs N] [--seconds S]

#include <filesystem>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/consistency_study.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_nees [--out DIR] [--runs N] [--seconds S]\n"
    "Runs a sliding window on N simulated recordings (50) of S seconds (20) for each mode of first estimates, and\n"
    "writes what plot/nees.py draws to DIR/csv (DIR is out/ unless given).\n";

}  // namespace

int main(int argc, char** argv) {
  ch5::ConsistencyOptions options;
  std::string out = "out";
  ch5::CommandLine line("ch5_nees", kUsage);
  line.Text("--out", &out);
  line.Number("--runs", 1, 10000, &options.runs);
  line.Number("--seconds", 1.0, 1e4, &options.seconds);
  return line.Run(argc, argv, [&] {
    const std::filesystem::path csv = std::filesystem::path(out) / "csv";
    std::filesystem::create_directories(csv);  // fails now and not after minutes
    const ch5::Progress progress;
    const auto rows = ch5::RunConsistencyStudy(options, [&](double f) { progress.Show("consistency", f); });
    ch5::WriteConsistencyTables(rows, csv);
  });
}
