/// Failure detection with limits of one's own. Apart from failure.cc, which the grader's workers link: there it would answer
/// stage 6j.

#include <cmath>
#include <tuple>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/window/failure.h"
#include "ch5_backend/window/window.h"

namespace ch5 {

void FailureLimits::Validate() const {
  CheckOption("FailureLimits::accelerometer_bias", accelerometer_bias, 0);
  CheckOption("FailureLimits::gyroscope_bias", gyroscope_bias, 0);
  CheckOption("FailureLimits::step", step, 0);
  CheckOption("FailureLimits::climb", climb, 0);
}

FailureDetector DetectFailuresBeyond(const FailureLimits& limits) {
  limits.Validate();
  return [limits](const Window& window, const Vec3& last_p) {
    const StampedState state = window.StateOf(window.frames.back());
    const Vec3 moved = state.T_W_B.p - last_p;
    const std::tuple<Failure, double, double> reached[] = {
        {Failure::kAccelerometerBias, state.b_a.norm(), limits.accelerometer_bias},
        {Failure::kGyroscopeBias, state.b_g.norm(), limits.gyroscope_bias},
        {Failure::kPositionJump, moved.norm(), limits.step},
        {Failure::kHeightJump, std::abs(moved.z()), limits.climb}};
    for (const auto& [failure, value, limit] : reached) {
      if (value > limit) return failure;
    }
    return Failure::kNone;
  };
}

}  // namespace ch5
