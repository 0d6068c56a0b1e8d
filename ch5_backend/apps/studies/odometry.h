#pragma once
/// Runs an estimator over a whole recording and compares its answers with the truth.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/window/estimator.h"
#include "ch5_backend/world/evaluate/trajectory_error.h"

namespace ch5 {

/// The estimator's settings for a recording's camera and IMU.
EstimatorOptions OptionsFor(const Calibration& calibration);

/// One of each kind, set up for this camera.
std::vector<std::unique_ptr<WindowPolicy>> AllPolicies(const Calibration& calibration);

/// What one image cost and gave.
struct WindowRow {
  double t = 0.0;
  double seconds = 0.0;  ///< spent on the image, its IMU readings included
  FrameReport report;
};

struct OdometryRun {
  std::string policy;
  std::vector<WindowRow> rows;       ///< one an image
  std::vector<StampedState> states;  ///< those that it answered
  std::optional<TrajectoryError> error;
  int restarts = 0;
  double realtime_factor = 0.0;  ///< duration of the recording / time spent
  double p99_window_ms = 0.0;    ///< of the images that were answered
};

using WatchOdometry = std::function<void(const Estimator&, const WindowRow&)>;

/// Feeds the recording in order of time.
/// @param watch  called after each image
void FeedRecording(const Recording& recording, Estimator* estimator, const WatchOdometry& watch);

/// The same with an estimator of its own, its answers compared with the truth.
OdometryRun RunOdometry(const Recording& recording, const EstimatorOptions& options,
                        std::unique_ptr<WindowPolicy> policy, const WatchOdometry& watch = nullptr);

}  // namespace ch5
