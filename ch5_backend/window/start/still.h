#pragma once
/// Standing still: the images do not move, and the IMU feels nothing but gravity. Then it tells its attitude and the
/// gyroscope's bias.

#include <deque>
#include <optional>
#include <vector>

#include "ch5_backend/types/measurements.h"

namespace ch5 {

struct StillOptions {
  double seconds = 1.0;         ///< for at least so long …
  double pixels = 3.0;          ///< … the points in the image moved less than this, as their median [px] …
  double acceleration = 0.3;    ///< … and the mean specific force is gravity up to this [m/s²]
  double focal_length = 460.0;  ///< [px]
  double gravity = 9.81;        ///< [m/s²]
};

/// What standing still tells. Position, yaw and speed are zero.
struct StillState {
  Qd q_W_B = Qd::Identity();  ///< brings the mean specific force to +z
  Vec3 b_a = Vec3::Zero();    ///< its part along gravity, all that can be told [m/s²]
  Vec3 b_g = Vec3::Zero();    ///< the mean rate [rad/s]
};

class StillDetector {
 public:
  explicit StillDetector(const StillOptions& options) : options_(options) {}

  void AddImu(const ImuReading& reading) { imu_.push_back(reading); }
  /// @return the state at this image, if the body has stood still up to it
  std::optional<StillState> AddFrame(const CameraFrame& frame);
  void Reset();

 private:
  StillOptions options_;
  std::deque<ImuReading> imu_;      // of the last `seconds`
  std::deque<CameraFrame> images_;  // likewise
};

/// The median of how far the points that both images see have moved, on the normalised plane; nullopt with fewer than
/// five of them. Outliers do not move a median.
std::optional<double> MedianMotion(const CameraFrame& a, const CameraFrame& b);

}  // namespace ch5
