/// Visual-inertial odometry on a recording: ch5_recording FOLDER --out DIR.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <stdexcept>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/implausible_images.h"
#include "ch5_backend/experiments/studies/implausible_readings.h"
#include "ch5_backend/experiments/studies/noise_check.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/experiments/studies/recording_warnings.h"
#include "ch5_backend/experiments/studies/sensor_faults.h"
#include "ch5_backend/experiments/studies/turn_warnings.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/files/tables/text_writer.h"

namespace {

using namespace ch5;

constexpr char kUsage[] =
    "usage: ch5_recording FOLDER --out DIR [--policy vins|okvis] [--batch] [--seconds A:B] [--window N]\n"
    "       [--max-features N] [--pixel-sigma S] [--first-estimates none|prior|full] [--estimate-extrinsic]\n"
    "       [--estimate-time-offset] [--keep-focal-length] [--mono] [--strict]\n"
    "Follows the camera and IMU recorded in FOLDER (calibration.yaml, imu.csv, tracks.csv and, to compare with,\n"
    "groundtruth.csv; ch5_backend/GUIDE.md has their format) with both window policies, and writes to DIR: "
    "trajectories in TUM's and EuRoC's format, and\n"
    "tables in DIR/csv, which figures/recording.py draws. After a restart a new segment begins, with its own files,\n"
    "POLICY_1.tum and so on, which is compared with the truth separately.\n"
    "A second camera, camera1 of calibration.yaml, is followed too; --mono leaves it out.\n"
    "Rows that cannot be read, unless they are more than one in twenty, and IMU readings that cannot be are left out,\n"
    "counted and named; with --strict the first is an error.\n"
    "--batch also solves the longest segment at once. --window is VINS's frames or OKVIS's keyframes. The other "
    "settings\n"
    "can also be set in calibration.yaml, as `max_features: 60` under `estimator:`; the command line takes "
    "precedence.\n";

struct Command {
  std::string folder, out;
  EstimatorWords given;
  bool batch = false, strict = false;
};

// A number, or "-" for NaN.
std::string Cell(double value, int width, int digits) {
  char text[32];
  if (std::isnan(value)) {
    std::snprintf(text, sizeof text, "%*s", width, "-");
  } else {
    std::snprintf(text, sizeof text, "%*.*f", width, digits, value);
  }
  return text;
}

// A row of the table, and below it what the run took, each restart and segment: no line beyond 80 columns.
void PrintRun(const OdometryRun& run) {
  constexpr double kDegrees = 180.0 / M_PI;
  const bool is_relative = run.error && run.relative;
  std::printf("%-8s  %s  %s  %s  %s  %s  %s  %8d\n", run.policy.c_str(),
              Cell(run.error ? run.error->position_rmse : kNoNumber, 7, 4).c_str(),
              Cell(is_relative ? run.relative->position_rmse : kNoNumber, 7, 4).c_str(),
              Cell(is_relative ? run.relative->DriftPercent() : kNoNumber, 9, 2).c_str(),
              Cell(is_relative ? run.relative->path : kNoNumber, 8, 2).c_str(),
              Cell(run.error ? run.error->scale : kNoNumber, 6, 4).c_str(),
              Cell(run.error ? run.error->yaw_rmse * kDegrees : kNoNumber, 9, 3).c_str(), run.restarts);
  std::printf("          %zu images; times real time %s, without start %s; p99 %s ms\n", run.states.size(),
              Cell(run.realtime_factor, 0, 1).c_str(), Cell(run.tracking_factor, 0, 1).c_str(),
              Cell(run.p99_window_ms, 0, 2).c_str());
  if (run.nees_windows > 0)
    std::printf("          NEES of the motion across %d windows: %s; if consistent 6\n", run.nees_windows,
                Cell(run.nees_motion, 0, 1).c_str());
  if (run.time_offset)
    std::printf("          images are taken %.1f ms %s than stamped\n", 1e3 * std::abs(*run.time_offset),
                *run.time_offset < 0.0 ? "earlier" : "later");
  for (const ImageResult& row : run.rows) {
    if (row.report.status != FrameReport::Status::kRestarted) continue;
    std::printf("          segment %d begins at %.2f s: %s\n", row.report.segment, row.t, row.report.message.c_str());
  }
  if (run.segments.size() < 2) return;
  for (const OdometrySegment& segment : run.segments) {
    std::printf("          segment %d, %.2f to %.2f s, %zu images", segment.id, segment.states.front().t,
                segment.states.back().t, segment.states.size());
    if (segment.error) {
      std::printf(": ATE %.4f m, scale %s, yaw %s deg", segment.error->position_rmse,
                  Cell(segment.error->scale, 0, 4).c_str(), Cell(segment.error->yaw_rmse * kDegrees, 0, 3).c_str());
    }
    std::printf("\n");
  }
}

// Says each on standard error, and keeps it for the report.
void Warn(const RecordingWarnings& more, RecordingWarnings* warnings) {
  for (const RecordingWarning& warning : more)
    std::fprintf(stderr, "ch5_recording: warning: %s\n", warning.words.c_str());
  warnings->insert(warnings->end(), more.begin(), more.end());
}

// Lines that cannot be read, clocks that jump, and keys that nobody reads.
RecordingWarnings CheckFiles(const std::vector<LeftOut>& left_out, const std::vector<ClockStep>& steps,
                             const std::vector<std::string>& keys) {
  RecordingWarnings warnings;
  for (const ClockStep& step : steps) {
    const double seconds = std::round(1e-9 * static_cast<double>(step.ns) + kClockPause);
    warnings.push_back({"clock_jump", seconds, step.t,
                        step.where + ": at " + Cell(step.t, 0, 1) + " s all clocks jump by " + Cell(seconds, 0, 0) +
                            " s, set anew or after a pause: a new segment begins, and times leave the jump out",
                        step.where, step.t});
  }
  for (const LeftOut& lines : left_out) {
    warnings.push_back({"left_out", static_cast<double>(lines.count), kNoNumber,
                        lines.file + ": lines left out: " + std::to_string(lines.count) + ", the first: " + lines.first,
                        lines.first});
  }
  if (!keys.empty()) {
    warnings.push_back({"cameras", static_cast<double>(keys.size()), kNoNumber,
                        "only camera and camera1 are used; keys of others: " + std::to_string(keys.size()) +
                            ", the first is " + keys.front()});
  }
  return warnings;
}

// Whether one of these is among them.
bool Has(const RecordingWarnings& warnings, std::initializer_list<const char*> names) {
  const auto is_named = [&](const auto& one) { return std::find(names.begin(), names.end(), one.name) != names.end(); };
  return std::any_of(warnings.begin(), warnings.end(), is_named);
}

// Focal length and clock, by the images' turns beside the gyroscope's; a dead one tells nothing.
RecordingWarnings CompareWithImages(const RecordingWarnings& readings, Recording* recording,
                                    OdometrySettings* settings) {
  if (Has(readings, {"gyroscope_dead"})) return {};
  RecordingWarnings warnings = CheckMeasurements(settings, recording, !Has(readings, {"gyroscope_rail"}));
  CorrectTurnGain(*settings, &warnings, recording);
  const RecordingWarnings clock = CheckClock(*recording, settings);
  warnings.insert(warnings.end(), clock.begin(), clock.end());
  return warnings;
}

// The recording, corrected as far as its own measurements tell.
Recording ReadAndCheck(const Command& command, OdometrySettings* settings, RecordingWarnings* warnings) {
  std::vector<LeftOut> left_out;
  std::vector<int> imu_lines;
  const std::filesystem::path folder = command.folder;
  Recording recording = ReadRecording(folder, command.strict ? nullptr : &left_out, &imu_lines);
  const auto extras = ReadCalibrationExtras(folder / "calibration.yaml");
  *settings = ReadOdometrySettings(extras.estimator, command.given);
  const auto readings = CheckReadings((folder / "imu.csv").string(), imu_lines, command.strict, &recording);
  settings->Restrict(&recording);
  Warn(CheckFiles(left_out, recording.clock_steps, extras.not_used), warnings);
  Warn(readings, warnings);
  Warn(CheckImages(command.strict, &recording), warnings);
  Warn(CheckTracks(command.strict, &recording), warnings);
  Warn(CheckNoise(&recording, settings), warnings);
  Warn(CompareWithImages(readings, &recording, settings), warnings);
  return recording;
}

// With these, what the estimates say of the accelerometer and of their windows is no more than can be expected …
constexpr std::initializer_list<const char*> kCauses = {"turns", "lens", "gyroscope_rail", "accelerometer_rail"};
// … and each of these looks like a fault of the accelerometer.
constexpr std::initializer_list<const char*> kAlike = {"gravity", "imu_rate", "turns_focal", "gyroscope_corrected",
                                                       "turns_rotation"};

// Follows the recording, and once or twice again where that has shown faults of the sensors.
OdometryStudy FollowAndCorrect(const OdometrySettings& settings, bool batch, Recording* recording,
                               RecordingWarnings* warnings) {
  const Progress progress;
  const auto show = [&](const std::string& policy, double fraction) { progress.Show(policy, fraction); };
  const bool may_be_faulty = !Has(*warnings, kCauses) && !Has(*warnings, kAlike);
  for (int round = 0;; ++round) {
    OdometryStudy study = RunOdometryStudy(*recording, show, settings, batch, true);
    progress.Clear();
    if (!may_be_faulty || round == 2) return study;
    const RecordingWarnings faults = CorrectFaults(study, settings, recording);
    if (faults.empty()) return study;
    Warn(faults, warnings);
  }
}

// Throws if no image has a state, with what each policy says of the last one.
void RequireAStart(const OdometryStudy& study, size_t images) {
  const auto is_silent = [](const OdometryRun& run) { return run.states.empty(); };
  if (!std::all_of(study.runs.begin(), study.runs.end(), is_silent)) return;
  std::string message = "no image was answered: in these " + std::to_string(images) + " images no policy found a start";
  for (const OdometryRun& run : study.runs) message += "\n  " + run.policy + ": " + run.rows.back().report.message;
  throw std::invalid_argument(message);
}

void CheckEstimates(const OdometryStudy& study, const OdometrySettings& settings, RecordingWarnings* warnings) {
  // Images that turn otherwise than the gyroscope tell nothing of the accelerometer, nor of a scale.
  const bool turns_otherwise = Has(*warnings, {"turns"}), is_explained = Has(*warnings, kCauses);
  const auto failures = turns_otherwise ? RecordingWarnings() : CheckFailures(study);
  Warn(failures, warnings);
  RequireAStart(study, study.recording.images.size());
  if (failures.empty() && !turns_otherwise) Warn(CheckStarts(study), warnings);
  Warn(CheckAgreement(study), warnings);
  if (!is_explained && failures.empty()) Warn(CheckResiduals(study, settings), warnings);
  Warn(CheckComparison(study), warnings);
}

void Run(const Command& command) {
  OdometrySettings settings;
  RecordingWarnings warnings;
  Recording recording = ReadAndCheck(command, &settings, &warnings);
  const OutputFolder made(command.out);
  std::printf("%zu images, %zu IMU measurements, %.1f s\n\n", recording.images.size(), recording.imu.size(),
              recording.images.back().t - recording.images.front().t);
  std::fflush(stdout);
  OdometryStudy study = FollowAndCorrect(settings, command.batch, &recording, &warnings);
  CheckEstimates(study, settings, &warnings);
  study.warnings = warnings;
  WriteOdometryTables(study, std::filesystem::path(command.out) / "csv");
  WriteOdometryTrajectories(study, command.out);

  std::printf("policy    ATE [m]  RPE [m]  drift [%%]  path [m]   scale  yaw [deg]  restarts\n");
  for (const OdometryRun& run : study.runs) PrintRun(run);
}

}  // namespace

int main(int argc, char** argv) {
  Command command;
  CommandLine line("ch5_recording", kUsage);
  line.Argument("FILE", &command.folder);
  line.Text("--out", &command.out);
  line.Flag("--batch", [&] { command.batch = true; });
  line.Flag("--strict", [&] { command.strict = true; });
  DeclareOdometryOptions(&line, &command.given);
  return line.Run(argc, argv, [&] { Run(command); });
}
