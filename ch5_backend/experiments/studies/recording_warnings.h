#pragma once
/// Doubtful data in a recording that can be followed all the same: warnings on the terminal and in the report.

#include <iomanip>
#include <sstream>
#include <string>

#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// A sentence, its numbers with two decimals.
template <typename... Words>
std::string Join(const Words&... words) {
  std::ostringstream sentence;
  sentence << std::fixed << std::setprecision(2);
  (sentence << ... << words);
  return sentence.str();
}

/// Sensors that measure at another rate than the calibration says, images too far apart, and what CheckTurns finds.
RecordingWarnings CheckMeasurements(OdometrySettings* settings, Recording* recording, bool seeks_cause = true);

/// Where a policy has restarted or never started: an accelerometer that points elsewhere than it should.
RecordingWarnings CheckFailures(const OdometryStudy& study);

/// A start, or restart, with a scale that is hardly known.
RecordingWarnings CheckStarts(const OdometryStudy& study);

/// Two policies whose paths through the same images are of different size: then at least one is wrong, whatever the cause.
RecordingWarnings CheckAgreement(const OdometryStudy& study);

/// Windows whose images lie farther from where IMU and landmarks expect them than their noise explains, whatever the cause.
RecordingWarnings CheckResiduals(const OdometryStudy& study, const OdometrySettings& settings);

/// A truth that the estimates cannot be compared with, or not well.
RecordingWarnings CheckComparison(const OdometryStudy& study);

}  // namespace ch5
