#pragma once
/// Why an estimate can no longer be true; the estimator then starts again.

#include <string>

namespace ch5 {

/// Why an estimate is not believed.
enum class Failure {
  kNone,
  kAccelerometerBias,
  kGyroscopeBias,
  kPositionJump,
  kHeightJump,
  kImuGap,          ///< no IMU reading for too long
  kImageGap,        ///< no image for so long that the IMU cannot bridge the time
  kImagesRejected,  ///< plenty of tracks, but hardly one that fits, for too long
  kSolveFailed      ///< the window has no solution: its normal equations are singular, or a number is not finite
};

/// "no IMU for too long", …
std::string ToString(Failure failure);

}  // namespace ch5
