#pragma once
/// Visual-inertial odometry: measurements in, one state per image out.
/// Threads: an estimator is used by one thread at a time; two estimators share nothing. To feed it from several threads,
/// or without waiting for its solves, see live_estimator.h. Its results depend on the measurements alone, not on the clock.
///
///   AddImu ─► measurements ─┐
///                           ├─► new frame, predicted ─► [not initialized: static or dynamic] ─► solve ─► slide
///   AddFrame ─► tracks ─────┘
///
/// Initialization is static (at rest, gravity and gyroscope bias are the measurements' mean) or dynamic (in motion, vision
/// is aligned with the IMU). With a second camera (Calibration::camera1, Image::tracks1), whose place on the body is known,
/// the dynamic one needs no motion: the first image has its scale already. A vehicle that stops while it is followed holds
/// its window until it moves, unless it has had edges of one's own since the start, which want each image solved. The
/// estimator restarts when its estimate can no longer be true, or when a gap in the measurements leaves nothing between two
/// images. A restart begins a new *segment*: its poses are known relative to one another, and not to those before. It begins
/// at the last estimated position and yaw, since nothing better is known.
///
/// This folder, `window/`, holds the sliding-window estimators. In: IMU measurements and feature tracks. Out: a state per
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
#include "ch5_backend/window/prediction.h"
#include "ch5_backend/window/start/sensor_check.h"
#include "ch5_backend/window/start/standstill.h"
#include "ch5_backend/window/state_covariance.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5 {

/// Parameters of camera, IMU and their clocks.
struct EstimatorOptions {
  Calibration calibration;  ///< the one place for T_B_C, focal length, noise of the IMU, and gravity
  WindowWeights weights = {};
  double time_offset = 0.0;  ///< initial guess of the delay of the camera's clock [s]
  bool estimate_time_offset = false;
  bool estimate_extrinsic = false;  ///< of both cameras, if there are two
  double max_outlier_pixels = 3.0;  ///< a landmark with a larger mean error is dropped, see RemoveOutliers [px]
  double max_imu_gap = 0.1;      ///< a longer time without IMU measurement is a gap: nothing is predicted across it …
  double max_bridged_gap = 1.2;  ///< … and a longer gap, or one without images, restarts the estimator [s]
  double max_rejecting = 1.0;    ///< so does it if plenty of tracks give hardly a landmark for longer [s]
  double reintegrate_gyroscope = 1e-4;             ///< preintegrate again if ‖δb_g‖ Δt exceeds this [rad]
  FailureDetector detect_failure = DetectFailure;  ///< VINS-Mono's limits; others: DetectFailuresBeyond
  StandstillOptions standstill = {};
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
  Marginalizer marginalizer = nullptr;  ///< as Window::marginalizer
  bool report_covariance = false;       ///< costs as much as a marginalization
  /// Called when the graph of a window is made, with the window and that graph, which has the frames' poses, speeds and
  /// biases already: adds the edges of further sensors at those of their measurements whose frames are in the window, and
  /// vertices of its own, which it must add each time. What leaves the window takes its edges along into the prior; a call
  /// that adds nothing changes no bit. An edge at a speed and bias must not be added again once that is null (OKVIS): the
  /// prior has it. Position and yaw of the oldest frame are held during the solve, so a vertex of one's own may be expressed
  /// in the world; after a restart (Window::segment) that is another world. The prior freezes where a vertex of one's own was
  /// linearized, so its edges should be nearly linear in it: turn a map about its first fix, not about an origin far away.
  /// Before a start in motion it is called too, and may tell the scale where steady speed leaves it unknown.
  OwnEdges own_edges = nullptr;

  /// @throws OptionError
  void Validate() const;
};

/// The result for one image.
struct FrameReport {
  enum class Status { kStarting, kTracking, kRestarted };
  Status status = Status::kStarting;
  int segment = 0;  ///< 0, 1, …: poses of one segment share a world frame; of a restart, the new one
  std::optional<StampedState> state;          ///< of this image, if tracking
  Failure failure = Failure::kNone;           ///< the reason for a restart
  std::string message;                        ///< why there is no state, in a sentence; empty if tracking
  Summary solve;                              ///< of no iterations at rest, when the window is held
  int landmarks = 0;                          ///< used in the solve
  std::optional<StateCovariance> covariance;  ///< of `state`, if options ask for it
  /// Once a segment, a second after its start: the relative σ of the scale, of which one camera and the IMU learn from
  /// changes of speed and direction alone. Of little meaning at rest; nullopt with a second camera.
  std::optional<double> scale_sigma;
};

/// The window as values of their own, which no later call changes.
struct Snapshot {
  struct FrameState {
    int id = 0;          ///< counts the images of a run
    StampedState state;  ///< speed and biases are zero if not `has_speed`
    bool is_keyframe = true;
    bool has_speed = true;  ///< false once speed and biases are marginalized (OKVIS)
  };
  struct Landmark {
    int track = 0;            ///< id of its track
    Vec3 p_W = Vec3::Zero();  ///< [m]
    int host = 0;             ///< id of the frame that saw it first
  };
  int segment = 0;
  std::vector<FrameState> frames;   ///< oldest first
  std::vector<Landmark> landmarks;  ///< those with a depth, by track
  Transform T_B_C;                  ///< as estimated
  std::optional<Transform> T_B_C1;  ///< that of camera 1, if there is one
  double time_offset = 0.0;         ///< likewise [s]
};

class Estimator {
 public:
  /// @throws OptionError if an option is out of its range
  /// @throws std::invalid_argument if the policy is null
  Estimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy);

  /// IMU measurements are kept until an image has used them, at most for a minute.
  /// @throws MeasurementError
  void AddImu(const ImuMeasurement& measurement);
  /// The measurements must reach beyond the image's time (plus the time offset): what is missing counts as a gap.
  /// @throws MeasurementError
  FrameReport AddFrame(const Image& frame);

  /// Replaces the initialization: the next image is taken in this state.
  /// @param state  its time is ignored
  /// @param J      square root of its information over [δp, δθ, v, b_a, b_g], any number of rows × 15. If it contains
  ///               position or yaw, no gauge prior is used (Window::prior_fixes_gauge)
  /// @throws std::invalid_argument if a number of state or J is not finite, or J has another number of columns
  void StartFrom(const StampedState& state, const MatXX& J);

  /// The newest state, carried on by the IMU to a later time: for output at the IMU's rate. The measurements so far are
  /// used; the last one holds to t.
  /// @param t  by the IMU's clock [s]
  /// @return nullopt while there is no estimate, before its newest frame, further than max_imu_gap from a measurement, or
  ///         longer after that frame than the IMU may carry (WindowWeights::max_imu_seconds)
  std::optional<StampedState> PredictAt(double t) const;

  /// Forgets all measurements, after which clocks may read anything: for drivers that have been restarted. A new segment
  /// begins, as after a gap; the calibration is again the given one.
  void Restart();

  Snapshot TakeSnapshot() const;
  int Segment() const { return segment_; }
  const EstimatorOptions& Options() const { return options_; }

  /// The window itself, for studies: its pointers lead to vertices that the next image changes.
  const Window& GetWindow() const { return window_; }
  const WindowPolicy& Policy() const { return *policy_; }
  int Restarts() const { return restarts_; }
  double TimeOffset() const { return window_.time_offset->GetEstimate()[0]; }

 private:
  void Reset();
  Failure GapBefore(const Image& image) const;
  FrameReport Restart(Failure failure, const std::string& message);
  void ForgetOldMeasurements();
  std::string WhyNotStarted() const;

  // A new frame (estimator.cc).
  void AppendFrame(const Image& image);
  void PredictFrame(Frame* frame) const;
  void DropUsedMeasurements();

  // Initialization (estimator_start.cc).
  void TryToStart(const Image& image);
  void StartFromGivenState();
  void RestAt(const StandstillState& standstill, const Image& image);
  std::optional<double> PixelsSinceStandstill(const Image& image) const;
  double SecondsInWindow() const;
  bool KnowsScaleSinceStandstill() const;
  bool InitializeInMotion();
  bool FindScaleByOwnEdges(const std::vector<StampedState>& shape);
  double ScaleThatOwnEdgesFit(const std::vector<StampedState>& shape);
  void BuildWithOwnEdges(size_t least_views);
  void SetStates(const std::vector<StampedState>& shape, double scale);
  void SlideBeforeStart(bool keeps_oldest);
  void BeginAt(double start_speed, bool knows_gravity);
  void LayUponLastSegment();
  void BeginTracking();

  // Tracking (estimator.cc).
  FrameReport Track(const Image& image);
  bool IsAtRest(const Image& image);
  FrameReport Hold(const Image& image);
  void Reintegrate();
  Summary Solve();
  Summary SolveWithGaugeHeld(const SolveOptions& options);
  bool OnlyTurns() const;
  bool RejectsImages(const Image& image);

  EstimatorOptions options_;
  std::unique_ptr<WindowPolicy> policy_;
  Window window_;
  SparseOptimizer optimizer_;
  StandstillDetector standstill_detector_;
  SensorCheck sensor_check_;
  std::string start_message_;                   // why the last image did not start the estimator
  static constexpr double kLeastSpacing = 0.1;  // of frames before the start [s]
  double start_spacing_ = kLeastSpacing;
  size_t frames_at_spacing_ = 0;                                    // how many have been kept so
  double last_attempt_ = -std::numeric_limits<double>::infinity();  // to start in motion: time of its newest frame
  ImuUnsteadiness unsteadiness_;
  std::vector<ImuMeasurement> imu_;                                    // from shortly before the newest frame on
  double forgotten_until_ = -std::numeric_limits<double>::infinity();  // measurements before were too many to keep
  double last_image_time_ = -std::numeric_limits<double>::infinity();
  int next_frame_ = 0;
  std::optional<std::pair<StampedState, MatXX>> given_start_;  // of StartFrom, until the next image
  Image standstill_image_;                                     // the last image at rest, while tracking the first …
  int standstill_frame_ = -1;                                  // … and the id of its frame; −1: none yet
  bool started_ = false, holds_ = false;                       // the latter: at rest while tracking
  bool has_own_edges_ = false;                                 // since this start
  std::optional<StateCovariance> last_covariance_;             // that was given out
  int restarts_ = 0, segment_ = 0;
  std::optional<StampedState> last_state_;  // the last that was given out, of this segment or one before
  Vec3 last_p_ = Vec3::Zero();              // of the newest frame after the previous solve
  double scale_report_time_ = std::numeric_limits<double>::infinity();
  double last_time_with_landmarks_ = 0.0;  // or with too few lasting tracks, or too little motion, to expect any
  // For each track id of the last image: in how many consecutive images it has been, since the start.
  Array<std::pair<int, int>> track_ages_;
};

}  // namespace ch5
