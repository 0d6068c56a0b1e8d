#include "ch5_backend/experiments/studies/window/flight.h"

#include <algorithm>

#include "ch5_backend/evaluate/trajectory_error.h"
#include "ch5_backend/math/so3.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/window/state_covariance.h"

namespace ch5 {

Recording Flight(const FlightOptions& flight) {
  HandheldOptions path{8.0};
  path.seed = 2;
  SimulationOptions options;
  options.calibration.camera_rate = flight.camera_rate;
  options.camera.max_tracks = flight.max_tracks;
  options.camera.pixel_sigma = flight.pixel_sigma;
  options.camera.drop_probability = 0.15;
  return SimulateInRoom(path, 400, options);
}

std::unique_ptr<WindowPolicy> MakeFlightPolicy(const std::string& name) {
  if (name == "okvis") return MakeOkvisPolicy({/*keyframes=*/3, /*temporal_frames=*/4});
  VinsOptions options;
  options.window_size = kFlightWindow - 1;
  options.least_tracked = 5;
  return MakeVinsPolicy(options);
}

std::unique_ptr<Estimator> StartFlight(const Recording& recording, std::unique_ptr<WindowPolicy> policy) {
  EstimatorOptions options{recording.calibration};
  options.max_rejecting = 1e9;  // few landmarks are normal here
  auto estimator = std::make_unique<Estimator>(options, std::move(policy));
  const StampedState& first = recording.truth.front();
  const Mat33 R = first.T_W_B.q.toRotationMatrix();
  MatXX J = MatXX::Zero(15, 15);
  J.block<2, 3>(3, 3) = 100.0 * R.topRows<2>();
  // The speed is known in B: a turn by δθ changes Rᵀv by [Rᵀv]× δθ.
  J.block<3, 3>(6, 3) = 10.0 * Hat(R.transpose() * first.v_W);
  J.block<3, 3>(6, 6) = 10.0 * R.transpose();
  J.diagonal().segment<3>(9).setConstant(50.0);
  J.diagonal().segment<3>(12).setConstant(500.0);
  estimator->StartFrom(first, J);
  return estimator;
}

void Fly(Recording recording, size_t images, std::unique_ptr<WindowPolicy> policy, const OdometryCallback& watch) {
  recording.images.resize(images);
  FeedRecording(recording, StartFlight(recording, std::move(policy)).get(), watch);
}

std::vector<PlacedFrame> PlacedFrames(const Window& window, const std::vector<StampedState>& recorded) {
  const Frame& oldest = window.frames.front();
  YawTransform to_truth;
  if (!recorded.empty()) {
    const auto first = StateAt(recorded, oldest.t);
    if (!first) return {};
    to_truth = AlignFirstPose({oldest.pose->q(), oldest.pose->p()}, first->T_W_B);
  }
  const Mat33 turn = to_truth.Rotation().toRotationMatrix();
  const std::vector<Mat66> covariances = PoseCovariances(window);
  std::vector<PlacedFrame> placed;
  for (size_t i = 0; i < covariances.size(); ++i) {
    const Frame& frame = window.frames[i];
    const Vec3 p = to_truth * frame.pose->p();
    const Mat33 claimed = turn * covariances[i].topLeftCorner<3, 3>() * turn.transpose();
    placed.push_back({frame.id, frame.t, p, claimed.topLeftCorner<2, 2>(), {}});
    if (const auto truth = StateAt(recorded, frame.t)) placed.back().truth = truth->T_W_B.p;
  }
  return placed;
}

bool IsInPrior(const Window& window, const Vertex& vertex) {
  if (!window.prior) return false;
  const auto& held = window.prior->Vertices();
  return std::any_of(held.begin(), held.end(), [&](const auto& one) { return one.get() == &vertex; });
}

const char* FateOf(const Vertex& vertex, bool is_left, const Window& window) {
  if (!is_left) return "marginalized";
  return IsInPrior(window, vertex) ? "in the prior" : "untouched";
}

WindowBefore::WindowBefore(std::string policy_name, const Window& window)
    : policy(std::move(policy_name)),
      frames(window.frames),
      landmarks(window.landmarks),
      rows(FirstRowsOf(window.graph)),
      H(DenseHessian(window.graph)) {}

bool WindowBefore::IsTaken(int id, const WindowLandmark& landmark, const Window& after) const {
  if (rows.count(landmark.inverse_depth.get()) == 0) return false;
  const int oldest = frames.front().id;
  return after.landmarks.count(id) == 0 || (policy == "vins" && landmark.Host() == oldest && after.IndexOf(oldest) < 0);
}

void WindowBefore::ForEachVertex(const Window& after, const TellVertex& tell) const {
  const auto of = [&](const char* kind, int id, bool is_keyframe, const Vertex* vertex, bool is_left) {
    if (rows.count(vertex) > 0) tell(kind, id, is_keyframe, *vertex, FateOf(*vertex, is_left, after));
  };
  for (const Frame& frame : frames) {
    const int at = after.IndexOf(frame.id);
    of("pose", frame.id, frame.is_keyframe, frame.pose.get(), at >= 0);
    of("speed", frame.id, frame.is_keyframe, frame.speed_bias.get(),
       at >= 0 && after.frames[static_cast<size_t>(at)].speed_bias);
  }
  for (const auto& [id, landmark] : landmarks)
    of("landmark", id, false, landmark.inverse_depth.get(), !IsTaken(id, landmark, after));
}

}  // namespace ch5
