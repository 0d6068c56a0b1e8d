#pragma once
/// Runs an estimator over a whole recording and compares its estimates with the truth.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/evaluate/trajectory_error.h"
#include "ch5_backend/window/estimator.h"

namespace ch5 {

/// The estimator's settings for a recording's camera and IMU.
EstimatorOptions OptionsFor(const Calibration& calibration);

/// One policy of each kind, set up for this camera.
std::vector<std::unique_ptr<WindowPolicy>> AllPolicies(const Calibration& calibration);

/// The time and result of one image.
struct WindowRow {
  double t = 0.0;
  double seconds = 0.0;  ///< for the image and its IMU readings
  FrameReport report;
};

struct OdometryRun {
  std::string policy;
  std::vector<WindowRow> rows;       ///< one per image
  std::vector<StampedState> states;  ///< of the images with an estimate
  std::optional<TrajectoryError> error;
  int restarts = 0;
  double realtime_factor = 0.0;  ///< duration of the recording / time spent
  double tracking_factor =
      0.0;  ///< the same of the images with an estimate, without those of the start; NaN if there is none
  double p99_window_ms = 0.0;  ///< of the images with an estimate; NaN if there is none
};

using OdometryCallback = std::function<void(const Estimator&, const WindowRow&)>;

/// Feeds the recording in order of time.
/// @param watch  called after each image
void FeedRecording(const Recording& recording, Estimator* estimator, const OdometryCallback& watch);

/// The same with a new estimator, whose estimates are then compared with the truth.
OdometryRun RunOdometry(const Recording& recording, const EstimatorOptions& options,
                        std::unique_ptr<WindowPolicy> policy, const OdometryCallback& watch = nullptr);

}  // namespace ch5
