#include "ch5_backend/experiments/studies/endurance_study.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <optional>
#include <stdexcept>

#include "ch5_backend/evaluate/align.h"
#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

constexpr double kImageRate = 10.0, kAlignSeconds = 60.0;

Recording Simulate(const EnduranceOptions& options) {
  HandheldOptions path;
  path.duration = options.frames / kImageRate;
  path.standstill_seconds = 2.0;
  SimulationOptions simulation;
  simulation.calibration.camera_rate = kImageRate;
  simulation.calibration.imu_rate = 100.0;
  simulation.camera.max_tracks = 30;
  return SimulateInRoom(path, 600, simulation, options.seed);
}

// How many images took how much of the processor's time, in steps of 1 %: what it holds does not grow with the flight.
class Times {
 public:
  void Add(double seconds) {
    const double step = std::log(seconds / kLeast) / std::log1p(kStep);
    ++counts_[static_cast<size_t>(std::clamp(step, 0.0, static_cast<double>(kSteps - 1)))];
    ++count_;
    most_ = std::max(most_, seconds);
  }
  /// That in which this share of the images was done [ms].
  double Milliseconds(double share) const {
    int64_t left = static_cast<int64_t>(std::ceil(share * static_cast<double>(count_)));
    size_t step = 0;
    while (step + 1 < kSteps && (left -= counts_[step]) > 0) ++step;
    return 1e3 * std::min(most_, kLeast * std::pow(1.0 + kStep, static_cast<double>(step + 1)));
  }

 private:
  static constexpr double kLeast = 1e-6, kStep = 0.01;
  static constexpr size_t kSteps = 2000;  // up to 440 s
  std::array<int64_t, kSteps> counts_ = {};
  int64_t count_ = 0;
  double most_ = 0.0;
};

// Linux: the second number of statm counts resident pages.
double ResidentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  if (!(statm >> total >> resident)) return std::numeric_limits<double>::quiet_NaN();
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

void RequireFinite(const StampedState& state, const std::string& policy) {
  const double sum =
      state.T_W_B.p.sum() + state.T_W_B.q.coeffs().sum() + state.v_W.sum() + state.b_a.sum() + state.b_g.sum();
  if (!std::isfinite(sum)) {
    throw std::runtime_error("the estimate of " + policy + " at t = " + std::to_string(state.t) + " s is not finite");
  }
}

void RunPolicy(const Recording& recording, const EnduranceOptions& options, std::unique_ptr<WindowPolicy> policy,
               const std::function<void(double)>& progress, std::vector<EnduranceRow>* rows) {
  Estimator estimator(EstimatorOptions{recording.calibration}, std::move(policy));
  const std::string name = estimator.Policy().Name();
  std::vector<StampedState> first_minute;
  std::optional<YawTransform> to_truth;  // over the first minute
  bool aligned = false;
  std::optional<Vec3> last;  // of the true positions
  int frame = 0;
  double distance = 0.0, seconds = 0.0;
  Times times;
  std::clock_t begin = std::clock();
  const auto look = [&](const ImageResult& row) {
    ++frame;
    seconds += row.seconds;
    times.Add(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    const StampedState truth = *StateAt(recording.truth, row.t);
    if (last) distance += (truth.T_W_B.p - *last).norm();
    last = truth.T_W_B.p;
    if (row.report.state) RequireFinite(*row.report.state, name);
    if (row.report.state && !aligned) first_minute.push_back(*row.report.state);
    if (!aligned && row.t >= kAlignSeconds) {
      const auto error = CompareTrajectories(first_minute, recording.truth);
      if (error) to_truth = error->alignment;
      aligned = true;
      first_minute = {};
    }
    if (frame % options.sample_every != 0) return;
    const double error = row.report.state && to_truth ? (*to_truth * row.report.state->T_W_B.p - truth.T_W_B.p).norm()
                                                      : std::numeric_limits<double>::quiet_NaN();
    rows->push_back({name, frame, row.t, distance, error, ResidentMegabytes(), 1e3 * seconds / options.sample_every,
                     times.Milliseconds(0.5), times.Milliseconds(0.99), times.Milliseconds(0.999),
                     times.Milliseconds(1.0), estimator.Restarts()});
    seconds = 0.0;
    if (progress) progress(static_cast<double>(frame) / static_cast<double>(recording.images.size()));
  };
  FeedRecording(recording, &estimator, [&](const Estimator&, const ImageResult& row) {
    look(row);
    begin = std::clock();  // the looking is not the estimator's
  });
}

}  // namespace

std::vector<EnduranceRow> RunEnduranceStudy(const EnduranceOptions& options,
                                            const std::function<void(const std::string&, double)>& progress) {
  const Recording recording = Simulate(options);
  std::vector<EnduranceRow> rows;
  for (auto&& policy : AllPolicies()) {
    const std::string name = policy->Name();
    RunPolicy(
        recording, options, std::move(policy),
        [&](double fraction) {
          if (progress) progress(name, fraction);
        },
        &rows);
  }
  return rows;
}

CsvTable EnduranceTable(const std::vector<EnduranceRow>& rows) {
  CsvTable table("policy,frame,t_s,distance_m,error_m,resident_mb,milliseconds,p50_ms,p99_ms,p999_ms,max_ms,restarts");
  for (const EnduranceRow& row : rows) {
    table.Row(row.policy, row.frame, row.t, row.distance, row.error, row.resident_mb, row.milliseconds, row.p50,
              row.p99, row.p999, row.max, row.restarts);
  }
  return table;
}

}  // namespace ch5
