#pragma once
/// Whether camera and gyroscope saw the same turns at the same times: warnings, and corrections where the cause is certain.

#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {

/// What makes estimators drift, or restart because images and IMU disagree: axes, the lens, the focal length, the gyroscope, the
/// clocks. What the turns tell of the delay of the camera's clock becomes the settings' first guess; a rolling shutter is taken
/// back, a gyroscope's drift allowed for, and the place of a camera that is turned is estimated.
/// @param seeks_cause  false for a gyroscope that was at its limit, whose readings are wrong where it was
void CheckTurns(OdometrySettings* settings, Recording* recording, bool seeks_cause, RecordingWarnings* warnings);

/// Where CheckTurns has found the gyroscope's scale factor wrong, or the focal length of a single camera, corrects it and says so;
/// the latter if the settings allow it. They also tell the delay of the camera's clock, as far as it is known.
void CorrectTurnGain(const OdometrySettings& settings, RecordingWarnings* warnings, Recording* recording);

/// After CheckTurns: sets the delay of the camera's clock where the recording decides it (see clock_check.h), and says so.
RecordingWarnings CheckClock(const Recording& recording, OdometrySettings* settings);

}  // namespace ch5
