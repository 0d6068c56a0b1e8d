#pragma once
/// A window made by hand, for the rules of the policies.

#include "ch5_backend/window/window.h"

namespace ch5 {

// `n` frames at rest, one meter apart along x, with half a second of IMU between them, all looking along +z.
inline Window Straight(int n) {
  Window window;
  for (int k = 0; k < n; ++k) {
    Frame frame;
    frame.id = 10 + k;
    frame.t = 0.5 * k;
    frame.pose = std::make_shared<VertexPose>(Qd::Identity(), Vec3(k, 0, 0));
    frame.speed_bias = std::make_shared<VertexSpeedBias>();
    if (k > 0) {
      const ImuSample sample{0.25, Vec3(0, 0, 9.81), Vec3::Zero()};
      frame.imu = std::make_shared<Preintegration>(sample, Vec3::Zero(), Vec3::Zero(), ImuNoise());
      frame.imu->Add(sample);
      frame.imu->Add(sample);
    }
    window.frames.push_back(frame);
  }
  window.extrinsic->SetFixed();
  window.time_offset->SetFixed();
  return window;
}

// Lets the frames first … last see a point of the world.
inline void See(int track, const Vec3& p_W, int first, int last, Window* window) {
  for (int k = first; k <= last; ++k) {
    const Frame& frame = window->frames[static_cast<size_t>(k)];
    window->landmarks[track].seen.push_back({frame.id, Vec3(p_W - frame.pose->p()).hnormalized(), Vec2::Zero()});
  }
}

inline bool UseAll(const Window&, const WindowLandmark& landmark) { return landmark.seen.size() >= 2; }

}  // namespace ch5
