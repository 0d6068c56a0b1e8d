#include "ch5_backend/experiments/studies/endurance_study.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <utility>

#include "ch5_backend/evaluate/align.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

constexpr double kImageRate = 10.0, kAlignSeconds = 60.0;
constexpr int kFull = 10;  // images with an estimate after a start, until the window is full

Recording Simulate(const EnduranceOptions& options) {
  SimulationOptions simulation;
  simulation.calibration.camera_rate = kImageRate;
  simulation.calibration.imu_rate = 100.0;
  simulation.camera.max_tracks = 30;
  return SimulateInRoom({options.frames / kImageRate, /*standstill_seconds=*/2.0}, 600, simulation, options.seed);
}

// How many images took how much of the processor's time, in steps of 1 %: what it holds does not grow with the flight.
class Times {
 public:
  void Add(double seconds) {
    const double step = std::log(seconds / kLeast) / std::log1p(kStep);
    ++counts_[static_cast<size_t>(std::clamp(step, 0.0, static_cast<double>(kSteps - 1)))];
    ++count_;
  }
  /// That in which this share of the images was done, or NaN of none [ms].
  double Milliseconds(double share) const {
    if (count_ == 0) return kNoNumber;
    int64_t left = static_cast<int64_t>(std::ceil(share * static_cast<double>(count_)));
    size_t step = 0;
    while (step + 1 < kSteps && (left -= counts_[step]) > 0) ++step;
    return 1e3 * kLeast * std::pow(1.0 + kStep, static_cast<double>(step + 1));
  }

 private:
  static constexpr double kLeast = 1e-6, kStep = 0.01;
  static constexpr size_t kSteps = 2000;  // up to 440 s
  std::array<int64_t, kSteps> counts_ = {};
  int64_t count_ = 0;
};

// Linux: the second number of statm counts resident pages.
double ResidentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  if (!(statm >> total >> resident)) return kNoNumber;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

void RequireFinite(const StampedState& state, const std::string& policy) {
  const double sum =
      state.T_W_B.p.sum() + state.T_W_B.q.coeffs().sum() + state.v_W.sum() + state.b_a.sum() + state.b_g.sum();
  if (!std::isfinite(sum)) {
    throw std::runtime_error("the estimate of " + policy + " at t = " + std::to_string(state.t) + " s is not finite");
  }
}

// How far an estimator's positions lie from the truth, once those of the first minute are aligned with it.
class Drift {
 public:
  explicit Drift(const std::vector<StampedState>& truth) : truth_(truth) {}
  /// NaN before, and without an estimate [m].
  double ErrorOf(const ImageResult& row) {
    const std::optional<StampedState>& state = row.report.state;
    if (!is_over_ && state) first_minute_.push_back(*state);
    if (!is_over_ && row.t >= kAlignSeconds) {
      is_over_ = true;
      if (const auto error = CompareTrajectories(std::exchange(first_minute_, {}), truth_))
        to_truth_ = error->alignment;
    }
    if (!state || !to_truth_) return kNoNumber;
    return (*to_truth_ * state->T_W_B.p - StateAt(truth_, row.t)->T_W_B.p).norm();
  }

 private:
  const std::vector<StampedState>& truth_;
  std::vector<StampedState> first_minute_;
  bool is_over_ = false;
  std::optional<YawTransform> to_truth_;
};

void Endure(const Recording& recording, const EnduranceOptions& options, std::unique_ptr<WindowPolicy> policy,
            const StudyProgress& progress, std::vector<EnduranceRow>* rows) {
  Estimator estimator(EstimatorOptions{recording.calibration}, std::move(policy));
  const std::string name = estimator.Policy().Name();
  Drift drift(recording.truth);
  Vec3 last = recording.truth.front().T_W_B.p;
  int frame = 0, segment = 0, estimates = 0;  // the last: of the segment
  double distance = 0.0, seconds = 0.0, longest = 0.0;
  Times times;
  std::clock_t begin = std::clock();
  FeedRecording(recording, &estimator, [&](const Estimator&, const ImageResult& row) {
    const double took = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    longest = std::max(longest, took);
    if (std::exchange(segment, row.report.segment) != row.report.segment) estimates = 0;
    if (row.report.state && ++estimates > kFull) times.Add(took);
    seconds += row.seconds;
    const Vec3 p = StateAt(recording.truth, row.t)->T_W_B.p;
    distance += (p - std::exchange(last, p)).norm();
    if (row.report.state) RequireFinite(*row.report.state, name);
    const double error = drift.ErrorOf(row);
    if (++frame % options.sample_every == 0) {
      rows->push_back({name, frame, row.t, distance, error, ResidentMegabytes(),
                       1e3 * std::exchange(seconds, 0.0) / options.sample_every, times.Milliseconds(0.5),
                       times.Milliseconds(0.99), times.Milliseconds(0.999), 1e3 * longest, estimator.Restarts()});
      if (progress) progress(name, static_cast<double>(frame) / static_cast<double>(recording.images.size()));
    }
    begin = std::clock();  // the looking is not the estimator's
  });
}

}  // namespace

std::vector<EnduranceRow> RunEnduranceStudy(const EnduranceOptions& options, const StudyProgress& progress) {
  const Recording recording = Simulate(options);
  std::vector<EnduranceRow> rows;
  for (auto&& policy : AllPolicies()) Endure(recording, options, std::move(policy), progress, &rows);
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
