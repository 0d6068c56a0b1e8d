#pragma once
/// Visual-inertial odometry: measurements in, one state per image out.
///
///   AddImu ─► readings ─┐
///                       ├─► new frame, predicted ─► [not initialized: static or dynamic] ─► solve ─► slide
///   AddFrame ─► tracks ─┘
///
/// Initialization is static (at rest, gravity and gyroscope bias are the readings' mean) or dynamic (in motion, vision is
/// aligned with the IMU). The estimator restarts when its estimate can no longer be true, or when a gap in the
/// measurements leaves nothing between two images.
///
/// This folder, `window/`, holds the sliding-window estimators. In: IMU readings and feature tracks. Out: a state per
/// image. Reading order: window.h (the values), this file, estimator.cc (one image, step by step), policy.h (what VINS-Mono
/// and OKVIS do differently), start/dynamic_initialization.h.

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/window/failure.h"
#include "ch5_backend/window/measurement_checks.h"
#include "ch5_backend/window/policy.h"
#include "ch5_backend/window/start/sensor_check.h"
#include "ch5_backend/window/start/standstill.h"

namespace ch5 {

/// What the estimator is told of camera, IMU and their clocks.
struct EstimatorOptions {
  Transform T_B_C;
  ImuNoise imu_noise;
  WindowWeights weights;
  double time_offset = 0.0;  ///< initial guess of the delay of the camera's clock [s]
  bool estimate_time_offset = false;
  bool estimate_extrinsic = false;
  double max_outlier_pixels = 3.0;      ///< a landmark with a larger mean reprojection error is dropped [px]
  double max_imu_gap = 0.1;             ///< after a longer time without IMU reading the estimator restarts [s]
  double max_rejecting = 1.0;           ///< so does it if plenty of tracks give hardly a landmark for longer [s]
  double reintegrate_gyroscope = 1e-4;  ///< preintegrate again if ‖δb_g‖ Δt exceeds this [rad]
  StandstillOptions standstill;
  double start_pixels = 8.0;  ///< the image motion after a standstill that is enough to start [px]
  // Standard deviations of the initial state.
  double start_speed = 0.1;               ///< [m/s]
  double moving_start_speed = 1.0;        ///< the same for a dynamic initialization [m/s]
  double start_bias_accelerometer = 0.1;  ///< [m/s²]
  double start_bias_gyroscope = 0.005;    ///< [rad/s]
  // Standard deviations of the given calibration, as far as it is estimated.
  double start_extrinsic_position = 0.05;  ///< [m]
  double start_extrinsic_rotation = 0.05;  ///< [rad]
  double start_time_offset = 0.02;         ///< [s]
  ObservabilityConstraints observability_constraints = ObservabilityConstraints::kNone;
  Marginalizer marginalizer;       ///< as Window::marginalizer
  bool report_covariance = false;  ///< costs as much as a marginalization

  /// @throws OptionError
  void Validate() const;
};

/// The result for one image.
struct FrameReport {
  enum class Status { kStarting, kTracking, kRestarted };
  Status status = Status::kStarting;
  std::optional<StampedState> state;  ///< of this image, if tracking
  Failure failure = Failure::kNone;   ///< the reason for a restart
  std::string message;                ///< why there is no state, in a sentence; empty if tracking
  Summary solve;
  int landmarks = 0;                     ///< used in the solve
  std::optional<Mat66> pose_covariance;  ///< of `state`, see window/pose_covariance.h; if options ask for it
};

class Estimator {
 public:
  /// @throws OptionError, or std::invalid_argument if the policy is null
  Estimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy);

  /// Readings are kept until an image has used them, at most for a minute.
  /// @throws MeasurementError
  void AddImu(const ImuMeasurement& reading);
  /// The readings must reach beyond the image's time (plus the time offset): what is missing counts as a gap.
  /// @throws MeasurementError
  FrameReport AddFrame(const Image& frame);

  /// Replaces the initialization: the next image is taken in this state.
  /// @param state  its time is ignored
  /// @param J      square root of its information over [δp, δθ, v, b_a, b_g], any number of rows × 15. If it contains
  ///               position or yaw, no gauge prior is used (Window::prior_fixes_gauge)
  /// @throws std::invalid_argument if a number of state or J is not finite, or J has another number of columns
  void StartFrom(const StampedState& state, const MatXX& J);

  const Window& GetWindow() const { return window_; }
  const WindowPolicy& Policy() const { return *policy_; }
  int Restarts() const { return restarts_; }
  double TimeOffset() const { return window_.time_offset->GetEstimate()[0]; }

 private:
  void Reset();
  Failure GapBefore(const Image& image) const;
  FrameReport Restart(Failure failure, const std::string& message);
  void ForgetOldReadings();
  std::string WhyNotStarted() const;

  // A new frame (estimator.cc).
  void AppendFrame(const Image& image);
  void Predict(Frame* frame) const;
  std::shared_ptr<Preintegration> Integrate(const Frame& from, double t1) const;
  void DropUsedReadings();

  // Initialization (estimator_start.cc).
  void TryToStart(const Image& image);
  void StartFromGivenState();
  void RestAt(const StandstillState& standstill, const Image& image);
  bool HasMovedSinceStandstill(const Image& image) const;
  bool InitializeInMotion();
  void BeginTracking();

  // Tracking (estimator.cc).
  FrameReport Track(const Image& image);
  void Reintegrate();
  Summary Solve();
  void RefineWithObservabilityConstraints();
  bool RejectsImages(const Image& image);

  EstimatorOptions options_;
  std::unique_ptr<WindowPolicy> policy_;
  Window window_;
  SparseOptimizer optimizer_;
  StandstillDetector standstill_detector_;
  SensorCheck sensor_check_;
  std::string start_message_;                                          // why the last image did not start the estimator
  std::vector<ImuMeasurement> imu_;                                    // from shortly before the newest frame on
  double forgotten_until_ = -std::numeric_limits<double>::infinity();  // readings before were too many to keep
  double last_image_time_ = -std::numeric_limits<double>::infinity();
  int next_frame_ = 0;
  std::optional<std::pair<StampedState, MatXX>> given_start_;  // of StartFrom, until the next image
  Image standstill_image_;                                     // the last image at rest …
  int standstill_frame_ = -1;                                  // … and the id of its frame; −1: none yet
  bool started_ = false;
  int restarts_ = 0;
  Vec3 last_p_ = Vec3::Zero();             // of the newest frame after the previous solve
  double last_time_with_landmarks_ = 0.0;  // or with too few tracks in the image to expect any
};

}  // namespace ch5
