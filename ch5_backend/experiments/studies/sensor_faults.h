#pragma once
/// Faults of an accelerometer, and of the images' stamps, that an estimator's run shows.

#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// What makes a force of an accelerometer's readings a:  (I + diag s) a(t + delay).
struct AccelerometerFault {
  using Numbers = Eigen::Vector4d;
  Numbers value = Numbers::Zero(), sigma = Numbers::Zero();  ///< s, and the delay against the gyroscope [s]
};

/// By one least-squares problem of the longest segment's first 40 s, in which these are unknown beside all states.
/// @return nullopt if it is too short
std::optional<AccelerometerFault> FindAccelerometerFault(const Recording& recording, EstimatorOptions options,
                                                         const OdometryRun& run);

/// How late a window's newest image is stamped [s]: its points are seen ẋ times as much ahead of where the IMU, from the frame
/// before, expects them. NaN where few points move, or each otherwise.
double LateOfNewest(const Window& window);

/// Corrects and names axes that are too long or too short and an accelerometer that is late for the gyroscope; or, if it finds
/// none, stamps of images that jitter, where even ones agree with the estimates. Another run may show more.
RecordingWarnings CorrectFaults(const OdometryStudy& study, const OdometrySettings& settings, Recording* recording);

}  // namespace ch5
