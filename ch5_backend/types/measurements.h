#pragma once
/// What a camera and an IMU on a body B deliver, and what an estimator answers.

#include <vector>

#include "ch5_backend/math/so3.h"

namespace ch5 {

/// Noise of one IMU measurement.
struct ImuNoise {
  double accelerometer = 0.08;       ///< σ [m/s²]
  double gyroscope = 0.004;          ///< σ [rad/s]
  double accelerometer_walk = 4e-5;  ///< σ of the bias' drift [m/s³]
  double gyroscope_walk = 2e-6;      ///< [rad/s²]
  /// VINS takes σ for the deviation of a measurement, so its results depend on the IMU's rate. With `continuous` they are
  /// densities (per √Hz) and the result does not.
  bool continuous = false;

  /// @throws OptionError
  void Validate() const;
};

/// One measurement of the IMU, in B.
struct ImuMeasurement {
  double t = 0.0;
  Vec3 acceleration = Vec3::Zero();  ///< specific force: +9.81 upwards at rest [m/s²]
  Vec3 gyroscope = Vec3::Zero();     ///< rate [rad/s]
};

/// The IMU's signal at one time, measured or interpolated, `dt` seconds after the sample before it (0 for the first).
struct ImuSample {
  double dt = 0.0;
  Vec3 acceleration = Vec3::Zero();  ///< specific force in B [m/s²]
  Vec3 gyroscope = Vec3::Zero();     ///< rate in B [rad/s]
};

/// A point followed through the images under one `id`, on the normalized plane z = 1 of an ideal camera. A point that two
/// cameras see has the same id in both.
struct TrackedPoint {
  int id = 0;
  Vec2 x = Vec2::Zero();
};

struct Image {
  double t = 0.0;                          ///< the camera's own stamp; its clock may be off against the IMU's
  std::vector<TrackedPoint> tracks;        ///< each id at most once; may be empty
  std::vector<TrackedPoint> tracks1 = {};  ///< likewise, of camera 1 at the same time; empty with one camera
};

/// Pose, speed and biases at one time: the ground truth's row, and an estimator's answer.
struct StampedState {
  double t = 0.0;
  Transform T_W_B;
  Vec3 v_W = Vec3::Zero();  ///< [m/s]
  Vec3 b_a = Vec3::Zero();  ///< accelerometer bias [m/s²]
  Vec3 b_g = Vec3::Zero();  ///< gyroscope bias [rad/s]
};

/// What the IMU felt from `t0` to `t1`: the measurements in between, and one interpolated linearly at each end.
/// @param imu  strictly increasing in time
/// @return     samples for a Preintegration; empty if t0 ≥ t1 or the measurements do not span [t0, t1]
std::vector<ImuSample> SamplesBetween(const std::vector<ImuMeasurement>& imu, double t0, double t1);

}  // namespace ch5
