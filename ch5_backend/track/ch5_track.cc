/// The front end as a program: ch5_track FOLDER --out DIR.

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <stdexcept>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/implausible_readings.h"
#include "ch5_backend/experiments/studies/recording_warnings.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/track/track_images.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_track FOLDER --out DIR [--mono] [--strict] [--check]\n"
    "Follows corners through the images of FOLDER, which is in EuRoC's layout (mav0/ with cam0, imu0 and perhaps\n"
    "cam1 and state_groundtruth_estimate0; ch5_backend/GUIDE.md), and writes the recording DIR: tracks.csv, imu.csv,\n"
    "calibration.yaml and, where the truth is known, groundtruth.csv. --mono leaves cam1 out.\n"
    "Rows and images that cannot be read are left out and counted; with --strict the first is an error.\n"
    "--check names what is doubtful in the data, as ch5_recording does: a gyroscope that is dead or in degrees, "
    "rates.\n";

// The doubts that concern the tracks: the estimators name these and others.
void Check(ch5::Recording recording, const std::string& folder) {
  ch5::OdometrySettings settings;
  std::vector<int> lines(recording.imu.size(), 0);
  std::iota(lines.begin(), lines.end(), 2);
  ch5::RecordingWarnings warnings = ch5::CheckReadings(folder + "/imu.csv", lines, false, &recording);
  const auto is_dead = [](const ch5::RecordingWarning& warning) { return warning.name == "gyroscope_dead"; };
  if (std::none_of(warnings.begin(), warnings.end(), is_dead)) {
    const auto more = ch5::CheckMeasurements(&settings, &recording);
    warnings.insert(warnings.end(), more.begin(), more.end());
  }
  for (const ch5::RecordingWarning& warning : warnings)
    std::fprintf(stderr, "ch5_track: warning: %s\n", warning.words.c_str());
}

void Run(const std::string& folder, const std::string& out, bool mono, bool strict, bool check) {
  std::vector<ch5::LeftOut> left_out;
  const auto counted = strict ? nullptr : &left_out;
  const ch5::EurocFolder euroc = ch5::ReadEurocFolder(folder, mono, counted);
  for (const std::string& note : euroc.notes) std::printf("%s\n", note.c_str());
  std::fflush(stdout);
  const ch5::Progress progress;
  const ch5::TrackedRecording tracked = ch5::TrackImages(
      euroc, {}, [&](double fraction) { progress.Show("track", fraction); }, counted);
  progress.Clear();
  for (const ch5::LeftOut& items : left_out)
    std::printf("%s: left out: %d, the first: %s\n", items.file.c_str(), items.count, items.first.c_str());
  const auto& frames = tracked.recording.images;
  size_t observations = 0, matched = 0;
  for (const ch5::Image& frame : frames) {
    observations += frame.tracks.size();
    matched += frame.tracks1.size();
  }
  if (observations == 0)
    throw std::invalid_argument("no corner was found in " + std::to_string(frames.size()) + " images");
  ch5::WriteRecording(tracked.recording, out);
  if (check) Check(tracked.recording, out);
  const auto count = static_cast<double>(frames.size());
  std::printf(
      "%zu images of %d × %d pixels, %.0f a second of one core; %.0f tracks an image, each %.0f images long on "
      "average\n",
      frames.size(), tracked.recording.calibration.width, tracked.recording.calibration.height, count / tracked.seconds,
      static_cast<double>(observations) / count, tracked.mean_length);
  if (euroc.recording.calibration.camera1) {
    const double percent = 100.0 * static_cast<double>(matched) / static_cast<double>(observations);
    std::printf("cam1 sees %.0f %% of them%s\n", percent,
                percent < 20.0 ? "; so few: do the images, T_BS and intrinsics belong to one camera each?" : "");
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string folder, out;
  bool mono = false, strict = false, check = false;
  ch5::CommandLine line("ch5_track", kUsage);
  line.Argument("FOLDER", &folder);
  line.Text("--out", &out);
  line.Flag("--mono", [&] { mono = true; });
  line.Flag("--strict", [&] { strict = true; });
  line.Flag("--check", [&] { check = true; });
  return line.Run(argc, argv, [&] { Run(folder, out, mono, strict, check); });
}
