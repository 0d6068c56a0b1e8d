/// The chapter's experiments on simulated scenes, as tables: ch5_chapter [--out DIR] writes DIR/csv/*.csv.

#include <filesystem>
#include <string>

#include "ch5_backend/experiments/studies/chapter_studies.h"
#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/experiments/studies/prior_study.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_chapter [--out DIR]\n"
    "Runs bundle adjustment on simulated scenes, the marginalization example, the prior-weight experiment,\n"
    "odometry on simulated recordings, and what slides out of a window; writes their tables to DIR/csv (DIR is out/\n"
    "unless given).\n";

void RunStudies(const std::filesystem::path& csv) {
  const ch5::Progress progress;
  const auto show = [&](const std::string& study, double fraction) { progress.Show(study, fraction); };
  ch5::RunMonoBaStudy(csv, [&](double fraction) { show("bundle adjustment", fraction); });
  ch5::RunMarginalizeStudy(csv);
  ch5::RunPriorStudy(csv, [&](double fraction) { show("prior weights", fraction); });
  ch5::WriteOdometryTables(ch5::RunOdometryStudy(ch5::SimulatedOdometryRecording(), show), csv);
  ch5::RunRestartStudy(csv);
  ch5::RunSlideStudy(csv);
}

}  // namespace

int main(int argc, char** argv) {
  std::string out = "out";
  ch5::CommandLine line("ch5_chapter", kUsage);
  line.Text("--out", &out);
  return line.Run(argc, argv, [&] { RunStudies(std::filesystem::path(out) / "csv"); });
}
