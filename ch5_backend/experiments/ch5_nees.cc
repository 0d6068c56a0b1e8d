/// Is the window as certain as it has a right to be? ch5_nees [--out DIR] [--runs N] [--seconds S] [--recordings DATA]

#include <cmath>
#include <filesystem>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/consistency_study.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/files/tables/text_writer.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_nees [--out DIR] [--runs N] [--seconds S] [--recordings DATA]\n"
    "Runs a sliding window on N simulated recordings (50) of S seconds (20) for each mode of first estimates, with\n"
    "observations used once and twice and hosts exact and noisy, and writes DIR/csv/consistency*.csv (DIR: out/). "
    "With\n"
    "--recordings it compares exact and noisy hosts on DATA/euroc_v1_01_easy, DATA/tango_walk and a simulated "
    "recording\n"
    "with outliers instead, and writes DIR/csv/host_noise.csv.\n";

// A row a policy and way to take hosts. Whole tracks, of which a noisy host makes one error, carry no loss (see
// types/visual/edge_track.h), so the losses of the single residuals are left out too, so that only one thing changes.
void AppendHosts(const std::string& name, const ch5::Recording& recording, ch5::CsvTable* table) {
  struct Way {
    const char* hosts;
    double cauchy;
    bool noisy;
  };
  for (const Way& way : {Way{"exact with loss", 1.0, false}, Way{"exact", 0.0, false}, Way{"noisy", 0.0, true}}) {
    for (auto&& policy : ch5::AllPolicies()) {
      ch5::EstimatorOptions options{recording.calibration};
      options.weights.cauchy = way.cauchy;
      options.weights.noisy_hosts = way.noisy;
      const ch5::OdometryRun run = ch5::RunOdometry(recording, options, std::move(policy));
      const auto error = [&](double ch5::TrajectoryError::*part) {
        return run.error ? *run.error.*part : std::nan("");
      };
      table->Row(name, run.policy, way.hosts, run.states.size(), run.restarts,
                 error(&ch5::TrajectoryError::position_rmse), error(&ch5::TrajectoryError::scale) - 1.0,
                 error(&ch5::TrajectoryError::rotation_rmse) * 180.0 / M_PI, run.milliseconds);
    }
  }
}

void CompareHosts(const std::filesystem::path& data, const std::filesystem::path& csv) {
  ch5::CsvTable table("recording,policy,hosts,images,restarts,ate_m,scale_error,rotation_error_deg,milliseconds");
  for (const char* name : {"euroc_v1_01_easy", "tango_walk"}) {
    AppendHosts(name, ch5::ReadRecording(data / name), &table);
  }
  AppendHosts("simulated", ch5::SimulatedOdometryRecording(), &table);
  table.Write(csv / "host_noise.csv");
}

}  // namespace

int main(int argc, char** argv) {
  ch5::ConsistencyOptions options;
  std::string out = "out", recordings;
  ch5::CommandLine line("ch5_nees", kUsage);
  line.Text("--out", &out);
  line.Option("--recordings", [&](const std::string& word) { recordings = word; });
  line.Number("--runs", 1, 10000, &options.runs);
  line.Number("--seconds", 1.0, 1e4, &options.seconds);
  return line.Run(argc, argv, [&] {
    const std::filesystem::path csv = std::filesystem::path(out) / "csv";
    const ch5::OutputFolder made(csv);
    if (!recordings.empty()) return CompareHosts(recordings, csv);
    const ch5::Progress progress;
    const auto results = ch5::RunConsistencyStudy(options, [&](double f) { progress.Show("consistency", f); });
    ch5::WriteConsistencyTables(results, csv);
  });
}
