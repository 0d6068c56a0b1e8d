/// Ten thousand images through each estimator: ch5_endurance [--out DIR] [--frames N]

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/endurance_study.h"
#include "ch5_backend/files/tables/text_writer.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_endurance [--out DIR] [--frames N]\n"
    "Feeds N simulated images (10000) to both window policies, and writes their memory, drift and time an image to\n"
    "DIR/csv, which figures/endurance.py draws (DIR is out/ unless given).\n";

}  // namespace

int main(int argc, char** argv) {
  ch5::EnduranceOptions options;
  std::string out = "out";
  ch5::CommandLine line("ch5_endurance", kUsage);
  line.Text("--out", &out);
  line.Number("--frames", 100, 1000000, &options.frames);
  return line.Run(argc, argv, [&] {
    const std::filesystem::path csv = std::filesystem::path(out) / "csv";
    const ch5::OutputFolder made(csv);
    const ch5::Progress progress;
    options.sample_every = std::max(options.sample_every, options.frames / 200);
    const auto rows = ch5::RunEnduranceStudy(
        options, [&](const std::string& policy, double fraction) { progress.Show(policy, fraction); });
    ch5::EnduranceTable(rows).Write(csv / "endurance.csv");
    for (size_t k = 0; k < rows.size(); ++k) {
      if (k + 1 < rows.size() && rows[k + 1].policy == rows[k].policy) continue;
      std::printf(
          "%-6s %d images, %.0f MB; an image takes p50 %.2f, p99 %.2f, p99.9 %.2f, the longest of all %.2f ms\n",
          rows[k].policy.c_str(), rows[k].frame, rows[k].resident_mb, rows[k].p50, rows[k].p99, rows[k].p999,
          rows[k].max);
    }
  });
}
