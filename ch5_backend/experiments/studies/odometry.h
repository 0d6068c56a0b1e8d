#pragma once
/// Runs an estimator over a whole recording and compares its estimates with the truth.

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ch5_backend/evaluate/relative_error.h"
#include "ch5_backend/evaluate/trajectory_error.h"
#include "ch5_backend/window/estimator.h"

namespace ch5 {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();  ///< an empty cell, null in JSON

/// Called with the present policy and the fraction done, 0 … 1.
using StudyProgress = std::function<void(const std::string& policy, double fraction)>;

/// One policy of each kind.
/// @param window  VINS: frames beside the newest; OKVIS: keyframes; 0: as the policy has it
std::vector<std::unique_ptr<WindowPolicy>> AllPolicies(int window = 0);

/// The time and result of one image.
struct ImageResult {
  double t = 0.0;
  double seconds = 0.0;  ///< for the image and its IMU measurements
  FrameReport report;
  /// By how much it seems to be stamped too late, by what is seen where the IMU expects it, if that is looked at [s].
  double late = kNoNumber;
};

/// What lies between two restarts: poses of one world frame, so it is compared with the truth by itself.
struct OdometrySegment {
  int id = 0;                            ///< FrameReport::segment
  std::vector<StampedState> states;      ///< at least one
  std::optional<TrajectoryError> error;  ///< scale and rotations are NaN where the truth has not moved by 5 cm
};

struct OdometryRun {
  std::string policy;
  std::vector<ImageResult> rows;          ///< one per image
  std::vector<StampedState> states;       ///< of the images with an estimate
  std::vector<OdometrySegment> segments;  ///< the same, those with an estimate
  /// Root mean squares over all segments, each aligned separately; the alignment and scale here are those of the longest.
  std::optional<TrajectoryError> error;
  std::optional<RelativeError> relative;  ///< of the longest segment
  int restarts = 0;
  std::optional<double> time_offset;          ///< of the camera's clock, as given or estimated last [s]
  Transform T_B_C;                            ///< likewise
  std::optional<StateCovariance> covariance;  ///< of the last estimate, if EstimatorOptions::report_covariance
  double realtime_factor = 0.0;               ///< duration of the recording / time spent
  double tracking_factor = 0.0;    ///< the same of the images with an estimate, without those of the start; NaN if none
  double milliseconds = 0.0;       ///< mean over the images
  double p99_window_ms = 0.0;      ///< of the images with an estimate; NaN if there is none
  double pixels_off = kNoNumber;   ///< σ of the newest images' points in their windows [px]
  double nees_motion = kNoNumber;  ///< motion_nees.h, if that was looked at
  int nees_windows = 0;            ///< in how many windows
};

/// That with the most states, or the end of `run.segments`.
std::vector<OdometrySegment>::const_iterator LongestSegment(const OdometryRun& run);

/// May take from the image's seconds what was spent on watching it.
using OdometryCallback = std::function<void(const Estimator&, ImageResult&)>;

/// The longest segment of a run solved at once (window/batch.h), as a run named "batch": its rows are those images, with
/// the seconds of the solve shared equally.
/// @return nullopt if no segment has two images
std::optional<OdometryRun> RunBatch(const Recording& recording, const EstimatorOptions& options,
                                    const OdometryRun& start);

/// Feeds the recording in order of time.
/// @param watch  called after each image
void FeedRecording(const Recording& recording, Estimator* estimator, const OdometryCallback& watch);

/// The same with a new estimator, whose estimates are then compared with the truth.
OdometryRun RunOdometry(const Recording& recording, const EstimatorOptions& options,
                        std::unique_ptr<WindowPolicy> policy, const OdometryCallback& watch = nullptr);

}  // namespace ch5
