#include "ch5_backend/experiments/studies/endurance_study.h"

#include <unistd.h>

#include <cmath>
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
  FeedRecording(recording, &estimator, [&](const Estimator&, const ImageResult& row) {
    ++frame;
    seconds += row.seconds;
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
                     estimator.Restarts()});
    seconds = 0.0;
    if (progress) progress(static_cast<double>(frame) / static_cast<double>(recording.images.size()));
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
  CsvTable table("policy,frame,t_s,distance_m,error_m,resident_mb,milliseconds,restarts");
  for (const EnduranceRow& row : rows) {
    table.Row(row.policy, row.frame, row.t, row.distance, row.error, row.resident_mb, row.milliseconds, row.restarts);
  }
  return table;
}

}  // namespace ch5
