#include "ch5_backend/window/failure.h"

#include <cmath>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/window/window.h"

namespace ch5 {

std::string ToString(Failure failure) {
  switch (failure) {
    case Failure::kNone: return "no failure";
    case Failure::kAccelerometerBias: return "an impossible accelerometer bias";
    case Failure::kGyroscopeBias: return "an impossible gyroscope bias";
    case Failure::kPositionJump: return "a jump";
    case Failure::kHeightJump: return "a jump in height";
    case Failure::kImuGap: return "no IMU for too long";
    case Failure::kImageGap: return "no image for too long";
    case Failure::kImagesRejected: return "images and IMU disagree";
    case Failure::kSolveFailed: return "the window's solve failed";
  }
  return "unknown";
}

void FailureLimits::Validate() const {
  CheckOption("FailureLimits::accelerometer_bias", accelerometer_bias, 0);
  CheckOption("FailureLimits::gyroscope_bias", gyroscope_bias, 0);
  CheckOption("FailureLimits::step", step, 0);
  CheckOption("FailureLimits::climb", climb, 0);
}

FailureDetector DetectFailuresBeyond(const FailureLimits& limits) {
  limits.Validate();
  return [limits](const Window& window, const Vec3& last_p) {
    const Frame& newest = window.frames.back();
    const Vec3 step = newest.pose->p() - last_p;
    if (newest.speed_bias->b_a().norm() > limits.accelerometer_bias) return Failure::kAccelerometerBias;
    if (newest.speed_bias->b_g().norm() > limits.gyroscope_bias) return Failure::kGyroscopeBias;
    if (step.norm() > limits.step) return Failure::kPositionJump;
    if (std::abs(step.z()) > limits.climb) return Failure::kHeightJump;
    return Failure::kNone;
  };
}

}  // namespace ch5
