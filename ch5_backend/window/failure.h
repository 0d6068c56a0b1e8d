#pragma once
/// Why an estimate can no longer be true; the estimator then starts again.

#include <functional>
#include <string>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// Why an estimate is not believed.
enum class Failure {
  kNone,
  kAccelerometerBias,
  kGyroscopeBias,
  kPositionJump,
  kHeightJump,
  kImuGap,          ///< no IMU measurement for too long
  kImageGap,        ///< no image for so long that the IMU cannot bridge the time
  kImagesRejected,  ///< plenty of tracks, but hardly one that fits, for too long
  kSolveFailed      ///< the window has no solution: its normal equations are singular, or a number is not finite
};

/// "no IMU for too long", …
std::string ToString(Failure failure);

struct Window;

/// Judges the newest frame of a window after a solve.
/// @param last_p  position of the newest frame after the previous solve; where images are more than 0.1 s apart, the place on
///                the straight line from there that is 0.1 s ago [m]
using FailureDetector = std::function<Failure(const Window& window, const Vec3& last_p)>;

/// What a state and its step since the image before, or in 0.1 s, may reach. The defaults are VINS-Mono's, as DetectFailure's
/// (vins_window.h).
struct FailureLimits {
  double accelerometer_bias = 2.5;  ///< ‖b_a‖ [m/s²]
  double gyroscope_bias = 1.0;      ///< ‖b_g‖ [rad/s]
  double step = 5.0;                ///< [m]
  double climb = 1.0;               ///< the height of a step, up or down [m]

  /// @throws OptionError
  void Validate() const;
};
/// @throws OptionError
FailureDetector DetectFailuresBeyond(const FailureLimits& limits);

}  // namespace ch5
