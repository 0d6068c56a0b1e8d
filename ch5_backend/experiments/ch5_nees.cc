/// Is the window as certain as it has a right to be? ch5_nees [--out DIR] [--runs N] [--seconds S] [--recordings DATA]

#include <filesystem>
#include <string>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/consistency_study.h"
#include "ch5_backend/experiments/studies/host_noise_study.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/files/recording_file.h"
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

void CompareHosts(const std::filesystem::path& data, const std::filesystem::path& csv) {
  ch5::CsvTable table = ch5::HostNoiseTable();
  for (const char* name : {"euroc_v1_01_easy", "tango_walk"}) {
    ch5::AppendHostNoise(name, ch5::ReadRecording(data / name), &table);
  }
  ch5::AppendHostNoise("simulated", ch5::SimulatedOdometryRecording(), &table);
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
    const ch5::ConsistencyStudy study =
        ch5::RunConsistencyStudy(options, [&](double f) { progress.Show("consistency", f); });
    ch5::WriteConsistencyTables(study, csv);
  });
}
