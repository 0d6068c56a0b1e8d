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

/// Images too far apart, and what makes estimators drift, or restart because images and
/// IMU disagree. What the turns tell of the delay of the camera's clock becomes the settings' first guess; a rolling shutter is
/// taken back, a gyroscope's drift allowed for, and the place of a camera that is turned is estimated; but no such cause is sought
/// in a gyroscope that was at its limit, whose readings are wrong where it was.
RecordingWarnings CheckMeasurements(OdometrySettings* settings, Recording* recording, bool seeks_cause = true);

/// Where CheckMeasurements has found the gyroscope's scale factor wrong, or the focal length of a single camera, corrects it and
/// says so; the latter if the settings allow it. They also tell the delay of the camera's clock, as far as it is known.
void CorrectTurnGain(const OdometrySettings& settings, RecordingWarnings* warnings, Recording* recording);

/// After CheckMeasurements: sets the delay of the camera's clock where the recording decides it (see clock_check.h), and says so.
RecordingWarnings CheckClock(const Recording& recording, OdometrySettings* settings);

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
