#include "ch5_backend/window/estimator.h"

#include <algorithm>
#include <utility>

#include "ch5_backend/consistency/position_yaw_prior.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/start_values.h"

namespace ch5 {
namespace {

// RejectsImages: what counts as few landmarks, as many tracks, and as a track that lasts.
constexpr int kFewLandmarks = 10, kPlentyOfTracks = 20, kLastingImages = 4;

// A hint for an implausible bias.
std::string LikelyCause(Failure failure) {
  if (failure == Failure::kGyroscopeBias) return "are its rates in rad/s, along the axes to which T_B_C leads?";
  if (failure == Failure::kAccelerometerBias)
    return "is the specific force in m/s², along the axes to which T_B_C leads?";
  return "";
}

// VINS-Mono's step limits assume at most 0.1 s between images; of a longer step only 0.1 s of motion is checked.
Vec3 BeginOfStep(const Window& window, const Vec3& last_p) {
  constexpr double kLongest = 0.1;  // [s]
  const size_t n = window.frames.size();
  const double seconds = n > 1 ? window.frames[n - 1].t - window.frames[n - 2].t : 0.0;
  if (seconds <= kLongest) return last_p;
  const Vec3& p = window.frames.back().pose->p();
  return p + kLongest / seconds * (last_p - p);
}

}  // namespace

void EstimatorOptions::Validate() const {
  calibration.Validate();
  weights.Validate();
  standstill.Validate();
  if (calibration.camera1 && weights.noisy_hosts) {
    throw OptionError("WindowWeights::noisy_hosts is for one camera, but there is a Calibration::camera1");
  }
  CheckOption("EstimatorOptions::time_offset", time_offset, -10, 10);
  CheckPositive("EstimatorOptions::max_outlier_pixels", max_outlier_pixels);
  CheckPositive("EstimatorOptions::max_imu_gap", max_imu_gap);
  CheckPositive("EstimatorOptions::max_bridged_gap", max_bridged_gap);
  CheckPositive("EstimatorOptions::max_rejecting", max_rejecting);
  CheckOption("EstimatorOptions::reintegrate_gyroscope", reintegrate_gyroscope, 0);
  CheckOption("EstimatorOptions::start_pixels", start_pixels, 0);
  CheckPositive("EstimatorOptions::start_speed", start_speed);
  CheckPositive("EstimatorOptions::moving_start_speed", moving_start_speed);
  CheckPositive("EstimatorOptions::start_bias_accelerometer", start_bias_accelerometer);
  CheckPositive("EstimatorOptions::start_bias_gyroscope", start_bias_gyroscope);
  CheckPositive("EstimatorOptions::start_extrinsic_position", start_extrinsic_position);
  CheckPositive("EstimatorOptions::start_extrinsic_rotation", start_extrinsic_rotation);
  CheckPositive("EstimatorOptions::start_time_offset", start_time_offset);
}

Estimator::Estimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy)
    : options_(options),
      policy_(std::move(policy)),
      optimizer_(&window_.graph),
      standstill_detector_(options.calibration, options.standstill) {
  options.Validate();
  if (!policy_) throw std::invalid_argument("Estimator: the policy is null");
  if (!options.detect_failure) throw std::invalid_argument("Estimator: detect_failure is null");
  Reset();
}

void Estimator::Reset() {
  if (started_) ++segment_;
  window_ = Window();
  window_.segment = segment_;
  SetCalibration(options_, &window_);
  window_.observability_constraints = options_.observability_constraints;
  window_.marginalizer = options_.marginalizer;
  policy_->Reset();
  standstill_detector_ = StandstillDetector(options_.calibration, options_.standstill);
  sensor_check_.Reset();
  start_message_.clear();
  start_spacing_ = kLeastSpacing;
  frames_at_spacing_ = 0;
  standstill_frame_ = -1;
  started_ = holds_ = has_own_edges_ = false;
}

void Estimator::Restart() {
  if (started_) ++restarts_;
  Reset();
  imu_.clear();
  unsteadiness_ = ImuUnsteadiness();
  track_ages_.clear();
  forgotten_until_ = last_attempt_ = last_image_time_ = -std::numeric_limits<double>::infinity();
}

void Estimator::AddImu(const ImuMeasurement& measurement) {
  CheckMeasurement(measurement, imu_);
  imu_.push_back(measurement);
  unsteadiness_.Add(measurement);
  ForgetOldMeasurements();
  sensor_check_.AddImu(measurement);
  standstill_detector_.AddImu(measurement);
}

// Without images the measurements would fill the memory. No image uses measurements from before the longest preintegration;
// but one may still come that is from before a pause of the recorder, so the newest of all are kept.
void Estimator::ForgetOldMeasurements() {
  constexpr double kKept = 60.0;
  constexpr size_t kFewest = 1000;
  const double kept = std::max(kKept, 2.0 * options_.weights.max_imu_seconds);
  if (imu_.size() < 2 * kFewest || imu_.back().t - imu_.front().t <= 2.0 * kept)
    return;  // seldom, as it moves the rest
  forgotten_until_ = std::min(imu_.back().t - kept, imu_[imu_.size() - kFewest].t);
  imu_.erase(imu_.begin(), std::find_if(imu_.begin(), imu_.end(),
                                        [&](const auto& measurement) { return measurement.t >= forgotten_until_; }));
}

FrameReport Estimator::AddFrame(const Image& image) {
  CheckImage(image, last_image_time_);
  if (image.t + TimeOffset() < forgotten_until_) {
    throw MeasurementError(
        "the image at t = " + std::to_string(image.t) +
        " s comes a minute or more after IMU measurements of its time, which are forgotten: feed images "
        "and measurements in order of time");
  }
  if (started_ && IsAtRest(image)) return Hold(image);
  const Failure gap = GapBefore(image);
  FrameReport report = gap == Failure::kNone ? FrameReport() : Restart(gap, "");
  if (!started_) sensor_check_.AddFrame(image);
  AppendFrame(image);
  if (!started_) TryToStart(image);
  if (started_) report = Track(image);
  if (!started_ && report.message.empty()) report.message = WhyNotStarted();
  last_image_time_ = image.t;
  report.segment = segment_;
  return report;
}

std::string Estimator::WhyNotStarted() const {
  const std::string suspicion = sensor_check_.Suspicion(options_.calibration.gravity, options_.calibration.noise);
  return suspicion.empty() ? start_message_ : suspicion;
}

// A gap so long that the IMU cannot connect this image with the newest frame, nor do images that go on meanwhile.
Failure Estimator::GapBefore(const Image& image) const {
  constexpr double kMostBetween = 0.5;  // images, while the IMU is silent [s]
  if (window_.frames.empty()) return Failure::kNone;
  const double t0 = window_.frames.back().t, t1 = image.t + TimeOffset();
  if (t1 - t0 > options_.weights.max_imu_seconds) return Failure::kImageGap;
  const bool bridges = started_ && t1 - t0 < kMostBetween;
  const double longest = bridges ? std::max(options_.max_imu_gap, options_.max_bridged_gap) : options_.max_imu_gap;
  return LongestImuGap(imu_, t0, t1) > longest ? Failure::kImuGap : Failure::kNone;
}

// What the sensors make suspicious is said too: it is the cause more often than the estimate is.
FrameReport Estimator::Restart(Failure failure, const std::string& message) {
  FrameReport report;
  report.message = ToString(failure) + (message.empty() ? "" : ", " + message);
  const std::string suspicion = sensor_check_.Suspicion(options_.calibration.gravity, options_.calibration.noise);
  if (!suspicion.empty()) report.message += "; " + suspicion;
  if (started_) {
    ++restarts_;
    report.status = FrameReport::Status::kRestarted;
    report.failure = failure;
  }
  Reset();
  return report;
}

// ---- a new frame -------------------------------------------------------------------------------------------------

void Estimator::AppendFrame(const Image& image) {
  Frame frame;
  frame.id = next_frame_++;
  frame.clock_offset = TimeOffset();
  // Times increase, even if the estimated offset has dropped by more than an image period.
  if (!window_.frames.empty()) {
    const double least = window_.frames.back().clock_offset - 0.5 * (image.t - last_image_time_);
    frame.clock_offset = std::max(frame.clock_offset, least);
  }
  frame.t = image.t + frame.clock_offset;
  frame.pose = MakeShared<VertexPose>();
  frame.speed_bias = MakeShared<VertexSpeedBias>();
  if (!window_.frames.empty()) PredictFrame(&frame);
  AppendImage(frame.id, image, &window_);
  window_.frames.push_back(std::move(frame));
  DropUsedMeasurements();
}

// The new frame's states from the newest frame's by the IMU.
void Estimator::PredictFrame(Frame* frame) const {
  const StampedState last = window_.StateOf(window_.frames.back());
  const ImuNoise& usual = options_.calibration.noise;
  const double gap = LongestImuGap(imu_, last.t, frame->t);
  const ImuNoise noise = gap > options_.max_imu_gap ? unsteadiness_.AcrossGap(gap, usual) : usual;
  frame->imu = IntegrateFrom(last, imu_, frame->t, noise);
  Window::SetState(Predict(last, *frame->imu, options_.calibration.gravity), *frame);
}

std::optional<StampedState> Estimator::PredictAt(double t) const {
  if (!started_) return std::nullopt;
  return ch5::PredictAt(window_.StateOf(window_.frames.back()), imu_, t, options_.calibration, options_.max_imu_gap,
                        options_.weights.max_imu_seconds);
}

void Estimator::DropUsedMeasurements() {
  const double t = window_.frames.back().t;
  const auto used =
      std::find_if(imu_.rbegin(), imu_.rend(), [t](const auto& measurement) { return measurement.t <= t; });
  if (used != imu_.rend()) imu_.erase(imu_.begin(), used.base() - 1);
}

Snapshot Estimator::TakeSnapshot() const {
  Snapshot snapshot;
  snapshot.segment = segment_;
  for (const Frame& frame : window_.frames) {
    snapshot.frames.push_back({frame.id, window_.StateOf(frame), frame.is_keyframe, frame.speed_bias != nullptr});
  }
  for (const auto& [track, landmark] : window_.landmarks) {
    if (!landmark.inverse_depth) continue;
    snapshot.landmarks.push_back({track, LandmarkInWorld(window_, landmark), landmark.Host()});
  }
  snapshot.T_B_C = window_.T_B_C();
  if (window_.extrinsic1) snapshot.T_B_C1 = window_.T_B_C1();
  snapshot.time_offset = TimeOffset();
  return snapshot;
}

// ---- tracking ----------------------------------------------------------------------------------------------------

FrameReport Estimator::Track(const Image& image) {
  FrameReport report;
  Reintegrate();
  policy_->NoteNewFrame(&window_);
  TriangulateLandmarks(&window_);
  if (!window_.time_offset->IsFixed()) SetVelocitiesByMotion(&window_);
  report.solve = Solve();
  if (report.solve.termination == Termination::kNotFinite ||
      report.solve.termination == Termination::kLinearSolverFailed) {
    return Restart(Failure::kSolveFailed, report.solve.message);
  }
  policy_->AfterSolve(&window_);
  const auto& vertices = window_.graph.Vertices();
  report.landmarks = static_cast<int>(std::count_if(
      vertices.begin(), vertices.end(), [](const auto& vertex) { return vertex->GetRole() == Role::kLandmark; }));
  const Failure failure = options_.detect_failure(window_, BeginOfStep(window_, last_p_));
  if (failure != Failure::kNone) return Restart(failure, LikelyCause(failure));
  if (options_.report_covariance) report.covariance = last_covariance_ = CovarianceOf(window_, window_.frames.back());
  if (window_.frames.back().t >= scale_report_time_) {
    report.scale_sigma = ScaleSigma(window_);
    scale_report_time_ = std::numeric_limits<double>::infinity();
  }
  RemoveOutliers(options_.max_outlier_pixels / options_.calibration.FocalLength(), &window_);
  if (RejectsImages(image)) return Restart(Failure::kImagesRejected, "");
  last_p_ = window_.frames.back().pose->p();
  report.status = FrameReport::Status::kTracking;
  report.state = last_state_ = window_.StateOf(window_.frames.back());
  policy_->Slide(&window_);
  return report;
}

// At rest there is no parallax, and tracks that begin there have no depth: solving on would leave a window without landmarks.
// Images alone would take slow motion for rest, so the speed must be small when it begins, and since then the images' motion.
bool Estimator::IsAtRest(const Image& image) {
  constexpr double kMostSpeed = 0.08;  // [m/s]
  const bool was_at_rest = std::exchange(holds_, false);
  if (!was_at_rest) standstill_detector_.ForgetForce();
  if (!standstill_detector_.AddFrame(image, TimeOffset()) || image.t - last_image_time_ > options_.standstill.seconds)
    return false;
  last_time_with_landmarks_ = image.t;
  const Frame& newest = window_.frames.back();
  if (has_own_edges_ || !newest.speed_bias) return false;  // one's own measurements want a solve
  if (!was_at_rest && newest.speed_bias->v().norm() > kMostSpeed) return false;
  const auto motion = was_at_rest ? TypicalMotion(standstill_image_, image) : std::nullopt;
  if (!motion) standstill_image_ = image;  // the first, or too few of its tracks are left
  return holds_ = !motion || *motion * options_.calibration.FocalLength() < 2.0 * options_.standstill.pixels;
}

// The newest frame rests too, with a second's delay, as a motion that begins is seen late: its time goes on, and what it
// sees. No frame is added and nothing is solved until an image moves.
FrameReport Estimator::Hold(const Image& image) {
  Frame& frame = window_.frames.back();
  const Image& then = standstill_detector_.OldestImage();
  const double t = then.t + TimeOffset();
  frame.is_at_rest = true;
  if (t > frame.t) {
    if (frame.imu) frame.imu->LetBiasesWalk(t - frame.t);
    frame.t = t;
    frame.clock_offset = TimeOffset();
    ReplaceNewestImage(then, &window_);
    DropUsedMeasurements();
  }
  last_image_time_ = image.t;
  FrameReport report;
  report.segment = segment_;
  report.status = FrameReport::Status::kTracking;
  report.state = window_.StateOf(frame);
  report.state->t = image.t + TimeOffset();
  report.state->v_W.setZero();
  last_state_ = report.state;
  if (options_.report_covariance) report.covariance = last_covariance_;
  return report;
}

// A preintegration follows the gyroscope's bias to first order only.
void Estimator::Reintegrate() {
  for (size_t k = 1; k < window_.frames.size(); ++k) {
    const auto& from = window_.frames[k - 1].speed_bias;
    const auto& imu = window_.frames[k].imu;
    if (!from || !imu) continue;
    if ((from->b_g() - imu->BiasGyroscope()).norm() * imu->SumDt() > options_.reintegrate_gyroscope) {
      imu->Reintegrate(from->b_a(), from->b_g());
    }
  }
}

// With constraints on all edges, the minimum is first found without those of the solve: the constrained Jacobians J' need
// not be a direction of descent far from the minimum.
Summary Estimator::Solve() {
  const bool refine = options_.observability_constraints == ObservabilityConstraints::kAllEdges;
  if (refine) window_.observability_constraints = ObservabilityConstraints::kMarginalizedEdges;
  const auto uses = [&](const Window& w, const WindowLandmark& l) { return policy_->Uses(w, l); };
  BuildGraph(options_.weights, uses, &window_, options_.own_edges);
  has_own_edges_ |= !window_.own_edges.empty();
  // A vertex of one's own may be tied to the world (where a satellite receiver's frame lies), so that must not slip.
  const Summary summary =
      has_own_edges_ ? SolveWithGaugeHeld(policy_->Options()) : optimizer_.Solve(policy_->Options());
  if (refine) {
    RemoveFailures(&window_);
    window_.observability_constraints = ObservabilityConstraints::kAllEdges;
    BuildGraph(options_.weights, uses, &window_, options_.own_edges);
    // To the nearby point with Σ J'ᵀWr = 0, to which no information along the gauge contributes.
    SolveOptions two_steps;
    two_steps.algorithm = Algorithm::kGaussNewton;
    two_steps.max_iterations = 2;
    SolveWithGaugeHeld(two_steps);  // there is no damping
  }
  return summary;
}

// Position and yaw of the oldest frame are held, if nothing else holds them.
Summary Estimator::SolveWithGaugeHeld(const SolveOptions& options) {
  std::shared_ptr<Edge> gauge_prior;
  if (!window_.prior_fixes_gauge && !window_.gauge_prior) {
    gauge_prior = MakePositionYawPrior(window_.frames.front().pose, 1e8);
    window_.graph.AddEdge(gauge_prior);
  }
  const Summary summary = optimizer_.Solve(options);
  if (gauge_prior) window_.graph.RemoveEdge(gauge_prior);
  return summary;
}

// Whether the window's camera positions lie so close together that the error of a landmark at kInitialDepth stays below what
// makes an outlier, whatever depth it is given: then landmarks come and go since depths are unknown.
bool Estimator::OnlyTurns() const {
  const auto camera = [&](const Frame& frame) -> Vec3 {
    return frame.pose->p() + frame.pose->q() * window_.extrinsic->p();
  };
  const double least = kInitialDepth * options_.max_outlier_pixels / options_.calibration.FocalLength();  // [m]
  return std::all_of(window_.frames.begin(), window_.frames.end(), [&](const Frame& frame) {
    return (camera(frame) - camera(window_.frames.back())).norm() < least;
  });
}

// When images and IMU contradict each other, all observations are removed as outliers, and the dead reckoning would go on
// forever: tracks last, but landmarks come and go.
bool Estimator::RejectsImages(const Image& image) {
  Array<std::pair<int, int>> ages;
  ages.reserve(image.tracks.size());
  for (const TrackedPoint& point : image.tracks) {
    const auto before = std::lower_bound(track_ages_.begin(), track_ages_.end(), std::pair(point.id, 0));
    ages.emplace_back(point.id, before != track_ages_.end() && before->first == point.id ? before->second + 1 : 1);
  }
  std::sort(ages.begin(), ages.end());
  track_ages_ = std::move(ages);
  const auto lasting_tracks = std::count_if(track_ages_.begin(), track_ages_.end(),
                                            [](const auto& entry) { return entry.second >= kLastingImages; });
  int lasting = 0;  // landmarks; there are mostly plenty among the first ones
  for (auto it = window_.landmarks.begin(); it != window_.landmarks.end() && lasting < kFewLandmarks; ++it) {
    if (it->second.inverse_depth && static_cast<int>(it->second.seen.size()) >= kLastingImages) ++lasting;
  }
  if (lasting == kFewLandmarks || lasting_tracks < kPlentyOfTracks || OnlyTurns()) last_time_with_landmarks_ = image.t;
  return image.t - last_time_with_landmarks_ > options_.max_rejecting;
}

}  // namespace ch5
