#pragma once
/// The noise of a recording's tracks and IMU, measured, against what is said of it.

#include "ch5_backend/evaluate/turn_agreement.h"
#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// The density of an IMU's white noise [unit/√Hz].
struct SensorNoise {
  MeasuredNoise noise;                          ///< no less than it is: motion may be in it
  std::optional<MeasuredNoise> with_vibration;  ///< if this is clearly more
};
/// By third differences, which hardly contain a motion, of the readings, and sixth ones of means over 40 ms: of white noise both are the
/// same, and what vibrates is gone from the means.
/// @return nullopt if it is not the same all along: then it is mostly vibration, which an IMU measures as it should
std::optional<SensorNoise> NoiseOfSensor(const std::vector<ImuMeasurement>& imu, Vec3 ImuMeasurement::*reading);

/// Names noise greater than the calibration's densities (of the IMU) or the settings' pixel_sigma, and sets these to it, unless
/// the user has decided the latter. Smaller noise is no fault: filters in an IMU's driver, and tracks that creep, hide from
/// both measurements a part of what disturbs an estimate.
RecordingWarnings CheckNoise(Recording* recording, OdometrySettings* settings);

}  // namespace ch5
