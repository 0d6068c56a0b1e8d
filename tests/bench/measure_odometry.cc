/// The time of each image of an estimator: measure_odometry POLICY [--tracks N] [--seconds N] [--cameras N] [--calibrate]
/// [--recording FOLDER] [--repeat N].

#include <time.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "ch5_backend/experiments/studies/command_line.h"
#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5::bench {
namespace {

constexpr char kUsage[] =
    "usage: measure_odometry POLICY [--tracks N] [--seconds N] [--cameras N] [--calibrate] [--recording FOLDER]\n"
    "                        [--repeat N]\n"
    "Runs an estimator (vins or okvis) over a simulated flight at 20 Hz, or over a recording, N times. Prints a line "
    "of\n"
    "JSON for each image, those before it has started too: the least time of all runs, of this thread alone.\n";

struct Options {
  std::string policy, recording;
  int tracks = 200, seconds = 30, cameras = 1, repeat = 1;
  bool calibrate = false;
};

Recording Flight(const Options& options) {
  if (!options.recording.empty()) return ReadRecording(options.recording);
  HandheldOptions path;
  path.duration = options.seconds;
  path.standstill_seconds = 1.5;
  SimulationOptions simulation;
  if (options.cameras == 2) simulation.calibration = ForwardStereo();
  simulation.camera.max_tracks = options.tracks;
  simulation.camera.drop_probability = 0.02;
  constexpr int kPointsPerTrack = 20;  // of the room: about a tenth of its points is in view
  return SimulateInRoom(path, kPointsPerTrack * options.tracks, simulation);
}

std::unique_ptr<WindowPolicy> PolicyOf(const std::string& name) {
  for (auto& policy : AllPolicies()) {
    if (policy->Name() == name) return std::move(policy);
  }
  throw std::invalid_argument("POLICY is vins or okvis, got '" + name + "'");
}

// Of this thread, so that other programs do not count.
double Now() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Answer {
  double seconds;
  Summary solve;
};

std::vector<Answer> RunOnce(const Recording& recording, const Options& options) {
  EstimatorOptions settings;
  settings.calibration = recording.calibration;
  settings.estimate_extrinsic = settings.estimate_time_offset = options.calibrate;
  Estimator estimator(settings, PolicyOf(options.policy));
  std::vector<Answer> answers;
  double last = Now();
  FeedRecording(recording, &estimator, [&](const Estimator&, const ImageResult& row) {
    const double now = Now();
    answers.push_back({now - last, row.report.solve});
    last = Now();
  });
  return answers;
}

void Measure(const Options& options) {
  const Recording recording = Flight(options);
  std::vector<Answer> best = RunOnce(recording, options);
  for (int k = 1; k < options.repeat; ++k) {
    const std::vector<Answer> again = RunOnce(recording, options);
    for (size_t i = 0; i < best.size(); ++i) best[i].seconds = std::min(best[i].seconds, again[i].seconds);
  }
  for (const Answer& answer : best) {
    std::printf("{\"seconds\": %.9g, \"steps\": %d, \"final_cost\": %.17g}\n", answer.seconds, answer.solve.iterations,
                answer.solve.final_cost);
  }
}

}  // namespace
}  // namespace ch5::bench

int main(int argc, char** argv) {
  ch5::bench::Options options;
  ch5::CommandLine line("measure_odometry", ch5::bench::kUsage);
  line.Argument("POLICY", &options.policy);
  line.Number("--tracks", 10, 10000, &options.tracks);
  line.Number("--seconds", 5, 10000, &options.seconds);
  line.Number("--cameras", 1, 2, &options.cameras);
  line.Number("--repeat", 1, 1000, &options.repeat);
  line.Flag("--calibrate", [&] { options.calibrate = true; });
  line.Option("--recording", [&](const std::string& word) { options.recording = word; });
  return line.Run(argc, argv, [&] { Measure(options); });
}
