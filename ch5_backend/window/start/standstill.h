#pragma once
/// Static initialization: at rest the images do not move and the accelerometer measures gravity alone. The
/// measurements then give roll, pitch and the gyroscope's bias.

#include <deque>
#include <optional>

#include "ch5_backend/math/array_memory.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

struct StandstillOptions {
  double seconds = 1.0;       ///< at rest if for this time [s] …
  double pixels = 3.0;        ///< … two fifths of the image's points move less than this [px] …
  double acceleration = 1.0;  ///< … the mean specific force differs from gravity by less than this [m/s²] …
  double change = 0.1;  ///< … and by less than this, beyond its noise, from what it was when the rest began [m/s²]

  /// @throws OptionError
  void Validate() const;
};

/// The state at rest. Position, yaw and speed are zero.
struct StandstillState {
  Qd q_W_B = Qd::Identity();  ///< rotates the mean specific force to +z
  Vec3 b_a = Vec3::Zero();    ///< its component along gravity, the only observable one [m/s²]
  Vec3 b_g = Vec3::Zero();    ///< the mean rate [rad/s]
};

/// Tells from IMU and images whether the body is at rest.
class StandstillDetector {
 public:
  /// @throws OptionError
  StandstillDetector(const Calibration& calibration, const StandstillOptions& options)
      : focal_length_(calibration.FocalLength()), gravity_(calibration.gravity), options_(options) {
    options.Validate();
  }

  void AddImu(const ImuMeasurement& measurement);
  /// @param time_offset  by which the image was taken later than stamped [s]
  /// @return the state at this image, if the body has been at rest until then
  std::optional<StandstillState> AddFrame(const Image& frame, double time_offset = 0.0);
  /// The oldest image of the last `seconds`, in whose time the body was at rest if it has been since.
  const Image& OldestImage() const { return images_.front(); }
  /// What the force is compared with begins anew.
  void ForgetForce() { first_force_.reset(); }

 private:
  /// @param mean        the specific force
  /// @param first_half  what the first half of the measurements adds to it
  bool HasForceChanged(const Vec3& mean, const Vec3& first_half);

  double focal_length_, gravity_;
  StandstillOptions options_;
  std::deque<ImuMeasurement, ArrayAllocator<ImuMeasurement>> imu_;  // of the last `seconds`
  std::deque<Image, ArrayAllocator<Image>> images_;                 // likewise
  std::optional<Vec3> first_force_;                                 // of the first half of a rest's first `seconds`
};

/// What two fifths of the points common to both images move less than, on the normalized plane; nullopt with fewer than
/// five of them. Not the median: where 30 % of the observations are false, half of the pairs are.
std::optional<double> TypicalMotion(const Image& a, const Image& b);

}  // namespace ch5
