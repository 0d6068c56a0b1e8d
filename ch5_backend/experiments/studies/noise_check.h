#pragma once
/// The noise of a recording's tracks and IMU, measured, against what is said of it.

#include "ch5_backend/evaluate/turn_agreement.h"
#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// The density of an IMU's white noise, and of what vibrates [unit/√Hz]: by third differences, which hardly contain a motion.
/// @return nullopt if it is not the same all along: then it is mostly vibration, which an IMU measures as it should
std::optional<MeasuredNoise> NoiseOfSensor(const std::vector<ImuMeasurement>& imu, Vec3 ImuMeasurement::*reading);

/// Names noise greater than the calibration's densities (of the IMU) or the settings' pixel_sigma, and sets these to it, unless
/// the user has decided the latter. Smaller noise is no fault: filters in an IMU's driver, and tracks that creep, hide from
/// both measurements a part of what disturbs an estimate.
RecordingWarnings CheckNoise(Recording* recording, OdometrySettings* settings);

}  // namespace ch5
