#include "ch5_backend/window/vins_window.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/window/landmarks.h"

namespace ch5 {

DropSet DropSetOfMarginOld(const Window& window) {
  const WindowFrame& oldest = window.frames.front();
  DropSet drop;
  drop.vertices = {oldest.pose, oldest.speed_bias};
  for (const auto& [id, landmark] : window.landmarks) {
    if (landmark.inverse_depth && landmark.Host() == oldest.id) drop.vertices.push_back(landmark.inverse_depth);
  }
  drop.edges = EdgesAt(window.graph, drop.vertices);
  return drop;
}

DropSet DropSetOfMarginSecondNew(const Window& window) {
  const auto& pose = window.frames[window.frames.size() - 2].pose;
  if (!window.prior) return {};
  const auto& held = window.prior->Vertices();
  if (std::find(held.begin(), held.end(), pose) == held.end()) return {};
  return {{window.prior}, {pose}};
}

void SlideWindow(MarginalizationFlag flag, Window* window) {
  auto& frames = window->frames;
  const auto leaving = flag == MarginalizationFlag::kOld ? frames.begin() : frames.end() - 2;
  ForgetObservations(leaving->id, window);
  const auto next = leaving + 1;
  if (flag == MarginalizationFlag::kOld) {
    next->imu = nullptr;
  } else {
    leaving->imu->Append(*next->imu);
    next->imu = leaving->imu;
  }
  frames.erase(leaving);
}

Failure DetectFailure(const Window& window, const Vec3& last_p) {
  const WindowFrame& newest = window.frames.back();
  if (newest.speed_bias->b_a().norm() > 2.5) return Failure::kAccelerometerBias;
  if (newest.speed_bias->b_g().norm() > 1.0) return Failure::kGyroscopeBias;
  const Vec3 step = newest.pose->p() - last_p;
  if (step.norm() > 5.0) return Failure::kPositionJump;
  if (std::abs(step.z()) > 1.0) return Failure::kHeightJump;
  return Failure::kNone;
}

}  // namespace ch5
