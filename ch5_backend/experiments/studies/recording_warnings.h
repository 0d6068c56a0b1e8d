#pragma once
/// What is doubtful in a recording that can be followed all the same: told on the terminal and in the report.

#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// Images too far apart, an IMU at the limits of its range, and what makes estimators drift, or start anew since images and
/// IMU disagree. If the delay of the camera's clock is to be estimated, what the turns tell of it becomes the first guess.
RecordingWarnings CheckMeasurements(const Recording& recording, OdometrySettings* settings);

/// Where a policy has restarted or never started: an accelerometer that points elsewhere than it should.
RecordingWarnings CheckFailures(const OdometryStudy& study);

/// A start, or restart, with a scale that is hardly known.
RecordingWarnings CheckStarts(const OdometryStudy& study);

/// A truth that the estimates cannot be compared with, or not well.
RecordingWarnings CheckComparison(const OdometryStudy& study);

}  // namespace ch5
