#include "ch5_backend/experiments/studies/odometry.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "ch5_backend/math/median.h"
#include "ch5_backend/window/batch.h"

namespace ch5 {

std::vector<OdometrySegment>::const_iterator LongestSegment(const OdometryRun& run) {
  return std::max_element(run.segments.begin(), run.segments.end(),
                          [](const auto& a, const auto& b) { return a.states.size() < b.states.size(); });
}

namespace {

// An offset of 0 that is not estimated is none.
bool IsClockKnown(const EstimatorOptions& options) {
  return options.estimate_time_offset || options.time_offset != 0.0;
}

// At rest the truth's positions are one point, to which any scale and any yaw aligns a trajectory.
bool HasMoved(const std::vector<StampedState>& states, const std::vector<StampedState>& truth) {
  constexpr double kLeast = 0.05;  // [m]
  std::optional<Vec3> first;
  for (const StampedState& state : states) {
    const auto at = StateAt(truth, state.t);
    if (at && !first) first = at->T_W_B.p;
    if (at && (at->T_W_B.p - *first).norm() > kLeast) return true;
  }
  return false;
}

// Each segment counts as often as it has states that were compared.
std::optional<TrajectoryError> Together(const std::vector<OdometrySegment>& segments) {
  std::vector<TrajectoryError> errors;
  for (const OdometrySegment& segment : segments) {
    if (segment.error) errors.push_back(*segment.error);
  }
  if (errors.empty()) return std::nullopt;
  if (errors.size() == 1) return errors.front();
  TrajectoryError all = *std::max_element(errors.begin(), errors.end(),
                                          [](const auto& a, const auto& b) { return a.time.size() < b.time.size(); });
  const auto root_mean = [&](double TrajectoryError::*rmse) {
    double sum = 0.0, count = 0.0;
    for (const TrajectoryError& error : errors) {
      if (std::isnan(error.*rmse)) continue;
      const double states = static_cast<double>(error.time.size());
      sum += states * error.*rmse * error.*rmse;
      count += states;
    }
    return std::sqrt(sum / count);
  };
  for (const auto rmse : {&TrajectoryError::position_rmse, &TrajectoryError::rotation_rmse, &TrajectoryError::yaw_rmse,
                          &TrajectoryError::velocity_rmse}) {
    all.*rmse = root_mean(rmse);
  }
  all.position.clear();
  all.time.clear();
  for (const TrajectoryError& error : errors) {
    all.position_max = std::max(all.position_max, error.position_max);
    all.position.insert(all.position.end(), error.position.begin(), error.position.end());
    all.time.insert(all.time.end(), error.time.begin(), error.time.end());
  }
  return all;
}

void Summarize(const Recording& recording, OdometryRun* run) {
  double total = 0.0, answered = 0.0;
  std::vector<double> milliseconds;
  for (const ImageResult& row : run->rows) {
    total += row.seconds;
    if (!row.report.state) continue;
    answered += row.seconds;
    milliseconds.push_back(1e3 * row.seconds);
  }
  run->milliseconds = 1e3 * total / static_cast<double>(run->rows.size());
  run->p99_window_ms = milliseconds.empty() ? kNoNumber : Quantile(milliseconds, 0.99);
  const double duration = run->rows.back().t - run->rows.front().t;
  run->realtime_factor = duration / std::max(total, 1e-9);
  const double share = static_cast<double>(milliseconds.size()) / static_cast<double>(run->rows.size());
  run->tracking_factor = share > 0.0 ? share * duration / std::max(answered, 1e-9) : kNoNumber;
  for (OdometrySegment& segment : run->segments) {
    segment.error = CompareTrajectories(segment.states, recording.truth);
    if (!segment.error || HasMoved(segment.states, recording.truth)) continue;
    segment.error->scale = segment.error->yaw_rmse = segment.error->rotation_rmse = kNoNumber;
  }
  run->error = Together(run->segments);
  const auto longest = LongestSegment(*run);
  if (longest != run->segments.end()) run->relative = CompareMotions(longest->states, recording.truth);
}

}  // namespace

std::vector<std::unique_ptr<WindowPolicy>> AllPolicies(int window) {
  std::vector<std::unique_ptr<WindowPolicy>> policies;
  VinsOptions vins;
  OkvisOptions okvis;
  if (window > 0) vins.window_size = okvis.keyframes = window;
  policies.push_back(MakeVinsPolicy(vins));
  okvis.temporal_frames = 5;  // one camera needs a longer base line than the stereo pair that OKVIS's 3 are meant for
  policies.push_back(MakeOkvisPolicy(okvis));
  return policies;
}

std::optional<OdometryRun> RunBatch(const Recording& recording, const EstimatorOptions& options,
                                    const OdometryRun& start) {
  const auto segment = LongestSegment(start);
  if (segment == start.segments.end() || segment->states.size() < 2) return std::nullopt;
  OdometryRun run;
  run.policy = "batch";
  std::vector<Image> images;
  for (size_t k = 0; k < start.rows.size(); ++k) {
    const ImageResult& row = start.rows[k];
    if (!row.report.state || row.report.segment != segment->id) continue;
    images.push_back(recording.images[k]);
  }
  const auto begin = std::chrono::steady_clock::now();
  const BatchResult result = SolveBatch(options, images, segment->states, recording.imu);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  run.states = result.states;
  if (IsClockKnown(options)) run.time_offset = result.time_offset;
  run.T_B_C = result.T_B_C;
  run.segments.push_back({0, result.states, {}});
  for (size_t k = 0; k < images.size(); ++k) {
    ImageResult& row = run.rows.emplace_back();
    row.t = images[k].t;
    row.seconds = seconds / static_cast<double>(images.size());
    row.report.status = FrameReport::Status::kTracking;
    row.report.state = result.states[k];
    row.report.landmarks = result.landmarks;
    row.report.solve = result.solve;
  }
  Summarize(recording, &run);
  return run;
}

void FeedRecording(const Recording& recording, Estimator* estimator, const OdometryCallback& watch) {
  using Clock = std::chrono::steady_clock;
  auto measurement = recording.imu.begin();
  for (const Image& frame : recording.images) {
    const Clock::time_point start = Clock::now();
    // One measurement beyond the image, so that the IMU can be interpolated at its time.
    const double until = frame.t + estimator->TimeOffset();
    while (measurement != recording.imu.end() &&
           (measurement == recording.imu.begin() || std::prev(measurement)->t < until)) {
      estimator->AddImu(*measurement++);
    }
    ImageResult row{frame.t, 0.0, estimator->AddFrame(frame)};
    row.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    watch(*estimator, row);
  }
}

OdometryRun RunOdometry(const Recording& recording, const EstimatorOptions& options,
                        std::unique_ptr<WindowPolicy> policy, const OdometryCallback& watch) {
  Estimator estimator(options, std::move(policy));
  OdometryRun run;
  run.policy = estimator.Policy().Name();
  FeedRecording(recording, &estimator, [&](const Estimator& now, ImageResult& row) {
    if (row.report.state) {
      run.states.push_back(*row.report.state);
      if (run.segments.empty() || run.segments.back().id != row.report.segment)
        run.segments.push_back({row.report.segment, {}, {}});
      run.segments.back().states.push_back(*row.report.state);
    }
    if (row.report.covariance) run.covariance = row.report.covariance;
    if (watch) watch(now, row);
    run.rows.push_back(row);
  });
  run.restarts = estimator.Restarts();
  if (IsClockKnown(options)) run.time_offset = estimator.TimeOffset();
  run.T_B_C = estimator.GetWindow().T_B_C();
  Summarize(recording, &run);
  return run;
}

}  // namespace ch5
