#include "ch5_backend/window/failure.h"

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

}  // namespace ch5
