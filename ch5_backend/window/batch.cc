#include "ch5_backend/window/batch.h"

#include <algorithm>
#include <stdexcept>

#include "ch5_backend/consistency/position_yaw_prior.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/prediction.h"
#include "ch5_backend/window/start_values.h"

namespace ch5 {
namespace {

// The measurements of [t0, t1] and one more at each end, so that they can be interpolated there.
std::vector<ImuMeasurement> ReadingsOver(const std::vector<ImuMeasurement>& imu, double t0, double t1) {
  const auto before = [](const ImuMeasurement& measurement, double t) { return measurement.t < t; };
  auto first = std::lower_bound(imu.begin(), imu.end(), t0, before);
  auto last = std::lower_bound(first, imu.end(), t1, before);
  if (first != imu.begin()) --first;
  if (last != imu.end()) ++last;
  return {first, last};
}

void AddFrames(const std::vector<Image>& images, const std::vector<StampedState>& start,
               const std::vector<ImuMeasurement>& imu, Window* window) {
  for (size_t k = 0; k < images.size(); ++k) {
    Frame frame;
    frame.id = static_cast<int>(k);
    frame.t = start[k].t;
    frame.clock_offset = start[k].t - images[k].t;
    frame.pose = std::make_shared<VertexPose>();
    frame.speed_bias = std::make_shared<VertexSpeedBias>();
    Window::SetState(start[k], frame);
    if (k > 0) {
      frame.imu =
          IntegrateFrom(start[k - 1], ReadingsOver(imu, start[k - 1].t, frame.t), frame.t, window->calibration.noise);
    }
    AppendImage(frame.id, images[k], window);
    window->frames.push_back(std::move(frame));
  }
}

void Reintegrate(const Window& window) {
  for (size_t k = 1; k < window.frames.size(); ++k) {
    const VertexSpeedBias& from = *window.frames[k - 1].speed_bias;
    window.frames[k].imu->Reintegrate(from.b_a(), from.b_g());
  }
}

// Behind the host's camera or in its center: a track that fits no point. Its inverse depth has no minimum, and one such
// landmark makes the step of all others short.
void RemoveUndetermined(Window* window) {
  for (auto it = window->landmarks.begin(); it != window->landmarks.end();) {
    const auto& vertex = it->second.inverse_depth;
    const bool stays = !vertex || (vertex->InverseDepth() > 0.0 && vertex->InverseDepth() < 1.0 / kLeastDepth);
    it = stays ? std::next(it) : window->landmarks.erase(it);
  }
}

bool IsUsed(const Window&, const WindowLandmark& landmark) { return landmark.seen.size() >= 2; }

BatchResult ResultOf(const Window& window, const Summary& solve) {
  BatchResult result;
  result.solve = solve;
  for (const Frame& frame : window.frames) result.states.push_back(window.StateOf(frame));
  result.T_B_C = window.T_B_C();
  if (window.extrinsic1) result.T_B_C1 = window.T_B_C1();
  result.time_offset = window.time_offset->GetEstimate()[0];
  for (const auto& [id, landmark] : window.landmarks) {
    if (!landmark.inverse_depth || !IsUsed(window, landmark)) continue;
    ++result.landmarks;
    result.observations += static_cast<int>(landmark.seen.size());
  }
  return result;
}

}  // namespace

BatchResult SolveBatch(const EstimatorOptions& options, const std::vector<Image>& images,
                       const std::vector<StampedState>& start, const std::vector<ImuMeasurement>& imu,
                       const BatchOptions& batch) {
  options.Validate();
  if (images.size() < 2 || images.size() != start.size() || imu.empty()) {
    throw std::invalid_argument("SolveBatch: two images or more are needed, with a state each, and IMU measurements");
  }
  Window window;
  SetCalibration(options, &window);
  AddFrames(images, start, imu, &window);
  window.prior = StartPrior(window, options.moving_start_speed, options);
  window.gauge_prior = MakePositionYawPrior(window.frames.front().pose, 1e8);
  TriangulateLandmarks(&window);

  SparseOptimizer optimizer(&window.graph, batch.threads);
  SolveOptions solve;
  solve.algorithm = Algorithm::kDogleg;  // damping would hold the scale, whose gradient is small
  solve.max_iterations = batch.max_iterations;
  solve.cost_tolerance = batch.cost_tolerance;
  Summary last;
  double seconds = 0.0;
  for (int round = 0; round < batch.rounds; ++round) {
    window.graph = Graph();  // a landmark that leaves need not be looked for in it
    RemoveUndetermined(&window);
    // At the start the states' errors are in the residuals too.
    RemoveOutliers((round > 0 ? 1.0 : 10.0) * options.max_outlier_pixels / options.calibration.FocalLength(), &window);
    if (round > 0) Reintegrate(window);
    BuildGraph(options.weights, IsUsed, &window, options.own_edges);
    last = optimizer.Solve(solve);
    seconds += last.seconds;
  }
  last.seconds = seconds;
  if (batch.watch) batch.watch(window);
  return ResultOf(window, last);
}

}  // namespace ch5
