#pragma once
/// A visual-inertial odometry: measurements in, one state per image out.
///
///   AddImu ─► readings ─┐
///                       ├─► new frame, predicted ─► [not started: stand still, or align] ─► solve ─► slide
///   AddFrame ─► tracks ─┘
///
/// It starts from standing still (gravity and gyroscope bias are the readings' mean), or while moving by aligning
/// vision with the IMU; it starts again when its estimate cannot be true, or when nothing ties two images together.

#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/window/policy.h"
#include "ch5_backend/window/start/still.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5 {

/// A measurement that cannot be used: its time is not after the last one's, a number is not finite, or a track stands
/// twice in an image. The estimator is as before.
class MeasurementError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

struct EstimatorOptions {
  Transform T_B_C;
  ImuNoise imu_noise;
  WindowWeights weights;
  double time_offset = 0.0;  ///< first guess of what the camera's clock is late by [s]
  bool estimate_time_offset = false;
  bool estimate_extrinsic = false;
  double max_outlier_pixels = 3.0;  ///< a landmark with more mean reprojection error is dropped [px]
  double max_imu_gap = 0.1;         ///< longer without a reading, and the estimate starts afresh [s]
  double max_rejecting = 1.0;       ///< longer with plenty of tracks and hardly a landmark, and it starts afresh [s]
  double reintegrate_gyroscope = 1e-4;  ///< integrate again if ‖δb_g‖ Δt exceeds this [rad]
  StillOptions still;
  double start_pixels = 8.0;  ///< so much motion in the image after standing still starts the estimate
  // What a start from standing still is sure of, σ
  double start_speed = 0.1;               ///< [m/s]
  double moving_start_speed = 1.0;        ///< the same for a start while moving
  double start_bias_accelerometer = 0.1;  ///< [m/s²]
  double start_bias_gyroscope = 0.005;    ///< [rad/s]
  // How good the given calibration is, σ of what is estimated of it
  double start_extrinsic_position = 0.05;  ///< [m]
  double start_extrinsic_rotation = 0.05;  ///< [rad]
  double start_time_offset = 0.02;         ///< [s]
  FirstEstimates first_estimates = FirstEstimates::kNone;
  bool report_covariance = false;  ///< costs as much as a marginalisation
};

/// What became of one image.
struct FrameReport {
  enum class Status { kStarting, kTracking, kRestarted };
  Status status = Status::kStarting;
  std::optional<StampedState> state;  ///< of this image, if tracking
  Failure failure = Failure::kNone;   ///< why it restarted
  Summary solve;
  int landmarks = 0;                     ///< used in the solve
  std::optional<Mat66> pose_covariance;  ///< of `state`, see window/place.h; if options ask for it
};

class Estimator {
 public:
  Estimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy);

  /// @throws MeasurementError
  void AddImu(const ImuReading& reading);
  /// The readings must reach beyond the image's time (plus the time offset): what is missing counts as a gap.
  /// @throws MeasurementError
  FrameReport AddFrame(const CameraFrame& frame);

  /// Instead of a start of its own: the next image is taken in this state.
  /// @param state  its time does not matter
  /// @param J      square root of its information over [δp, δθ, v, b_a, b_g], any number of rows × 15. Where it tells
  ///               position or yaw, the window remembers them (Window::knows_place), else it holds the gauge as it likes
  void StartFrom(const StampedState& state, const MatXX& J);

  const Window& GetWindow() const { return window_; }
  const WindowPolicy& Policy() const { return *policy_; }
  bool Started() const { return started_; }
  int Restarts() const { return restarts_; }
  double TimeOffset() const { return window_.time_offset->GetEstimate()[0]; }

 private:
  void Check(const CameraFrame& frame) const;
  Failure GapBefore(const CameraFrame& image) const;
  FrameReport Restart(Failure failure);
  void AppendFrame(const CameraFrame& frame);
  void AppendTracks(const CameraFrame& frame);
  std::shared_ptr<Preintegration> Integrate(const WindowFrame& from, double t1) const;
  void Start(const CameraFrame& image);
  bool MovedSinceStill(const CameraFrame& image) const;
  bool AlignWhileMoving();
  void BeginTracking(double speed_sigma);
  void BeginGiven();
  void StandStill(const StillState& still, const CameraFrame& image);
  FrameReport Track(const CameraFrame& image);
  bool RejectsImages(const CameraFrame& image);
  Summary Solve();
  void Reintegrate();
  void Forget();

  EstimatorOptions options_;
  std::unique_ptr<WindowPolicy> policy_;
  Window window_;
  SparseOptimizer optimizer_;
  StillDetector still_;
  std::vector<ImuReading> imu_;  // since a little before the newest frame
  double last_image_time_ = -std::numeric_limits<double>::infinity();
  int next_frame_ = 0;
  std::optional<std::pair<StampedState, MatXX>> given_;  // until the next image
  CameraFrame still_image_;                              // the last one that stood still …
  int still_image_id_ = -1;                              // … and its frame; −1: none yet
  bool started_ = false;
  int restarts_ = 0;
  Vec3 last_p_ = Vec3::Zero();
  double last_sight_ = 0.0;  // when landmarks last lasted, or the images offered none
};

}  // namespace ch5
