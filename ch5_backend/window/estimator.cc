#include "ch5_backend/window/estimator.h"

#include <algorithm>

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/place.h"
#include "ch5_backend/window/start/initialization.h"

namespace ch5 {
namespace {

// Images between standing still and the first solve; images to start from while moving.
constexpr size_t kFramesToStart = 4, kFramesToStartMoving = 8;
constexpr int kFewLandmarks = 10;
constexpr size_t kPlentyOfTracks = 20, kLastingImages = 4;

std::string At(double t) { return " at t = " + std::to_string(t) + " s"; }

// What a start knows, as one prior: speed and biases of the oldest frame, and the calibration as far as it is
// estimated. Without the latter the first windows, which have moved little, would throw the camera about.
std::shared_ptr<EdgePrior> StartPrior(const Window& window, double speed, const EstimatorOptions& options) {
  Prior prior;
  std::vector<double> sigmas;
  const auto know = [&](const std::shared_ptr<Vertex>& vertex, std::initializer_list<double> sigmas_of_threes) {
    if (vertex->IsFixed()) return;
    prior.vertices.push_back(vertex);
    prior.x0.push_back(vertex->Parameters());
    for (const double sigma : sigmas_of_threes) {
      for (int k = 0; k < std::min(3, vertex->LocalDimension()); ++k) sigmas.push_back(sigma);
    }
  };
  know(window.frames.front().speed_bias, {speed, options.start_bias_accelerometer, options.start_bias_gyroscope});
  know(window.extrinsic, {options.start_extrinsic_position, options.start_extrinsic_rotation});
  know(window.time_offset, {options.start_time_offset});
  prior.J = Eigen::Map<VecX>(sigmas.data(), static_cast<Eigen::Index>(sigmas.size())).cwiseInverse().asDiagonal();
  prior.r0 = VecX::Zero(prior.J.rows());
  return std::make_shared<EdgePrior>(std::move(prior));
}

}  // namespace

Estimator::Estimator(const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy)
    : options_(options), policy_(std::move(policy)), optimizer_(&window_.graph), still_(options.still) {
  optimizer_.SetDamping(Damping::kDiagonal);
  Forget();
}

void Estimator::Forget() {
  window_ = Window();
  window_.first_estimates = options_.first_estimates;
  window_.extrinsic->SetPose(options_.T_B_C.q, options_.T_B_C.p);
  window_.extrinsic->SetFixed(!options_.estimate_extrinsic);
  window_.time_offset->SetEstimate(VertexScalar::Estimate(options_.time_offset));
  window_.time_offset->SetFixed(!options_.estimate_time_offset);
  policy_->Reset();
  still_.Reset();
  still_image_id_ = -1;
  started_ = false;
}

void Estimator::AddImu(const ImuReading& reading) {
  if (!std::isfinite(reading.t) || !reading.acceleration.allFinite() || !reading.gyroscope.allFinite()) {
    throw MeasurementError("the IMU reading" + At(reading.t) + " holds a number that is not finite");
  }
  if (!imu_.empty() && reading.t <= imu_.back().t) {
    throw MeasurementError("the IMU reading" + At(reading.t) +
                           (reading.t == imu_.back().t ? " repeats" : " is before") + " the one" + At(imu_.back().t));
  }
  imu_.push_back(reading);
  if (!started_) still_.AddImu(reading);
}

void Estimator::Check(const CameraFrame& frame) const {
  if (!std::isfinite(frame.t)) throw MeasurementError("the image's time is not finite");
  if (frame.t <= last_image_time_) {
    throw MeasurementError("the image" + At(frame.t) + (frame.t == last_image_time_ ? " repeats" : " is before") +
                           " the one" + At(last_image_time_));
  }
  std::vector<int> ids;
  for (const TrackedPoint& point : frame.tracks) {
    if (!point.x.allFinite()) {
      throw MeasurementError("track " + std::to_string(point.id) + " of the image" + At(frame.t) + " is not finite");
    }
    ids.push_back(point.id);
  }
  std::sort(ids.begin(), ids.end());
  const auto repeated = std::adjacent_find(ids.begin(), ids.end());
  if (repeated != ids.end()) {
    throw MeasurementError("track " + std::to_string(*repeated) + " stands twice in the image" + At(frame.t));
  }
}

// What keeps the IMU from tying this image to the newest frame.
Failure Estimator::GapBefore(const CameraFrame& image) const {
  if (window_.frames.empty()) return Failure::kNone;
  const double t0 = window_.frames.back().t, t1 = image.t + TimeOffset();
  if (t1 - t0 > options_.weights.max_imu_seconds) return Failure::kImageGap;
  if (imu_.empty()) return Failure::kImuGap;
  double last = std::min(t0, imu_.front().t);
  for (auto reading = imu_.begin(); reading != imu_.end() && last < t1; ++reading) {
    if (reading->t - last > options_.max_imu_gap) return Failure::kImuGap;
    last = reading->t;
  }
  return t1 - last > options_.max_imu_gap ? Failure::kImuGap : Failure::kNone;
}

FrameReport Estimator::Restart(Failure failure) {
  FrameReport report;
  if (started_) {
    ++restarts_;
    report.status = FrameReport::Status::kRestarted;
    report.failure = failure;
  }
  Forget();
  return report;
}

FrameReport Estimator::AddFrame(const CameraFrame& frame) {
  Check(frame);
  const Failure gap = GapBefore(frame);
  FrameReport report = gap == Failure::kNone ? FrameReport() : Restart(gap);
  AppendFrame(frame);
  if (!started_) Start(frame);
  if (started_) report = Track(frame);
  last_image_time_ = frame.t;
  return report;
}

// The new frame's states, as the IMU predicts them:
//   q_j = q_i γ,   v_j = v_i − G t + R_i β,   p_j = p_i + v_i t − ½ G t² + R_i α
void Estimator::AppendFrame(const CameraFrame& image) {
  WindowFrame frame;
  frame.id = next_frame_++;
  frame.clock_offset = TimeOffset();
  if (!window_.frames.empty()) {  // time goes on, even if the offset has jumped back by more than an image's length
    const double least = window_.frames.back().clock_offset - 0.5 * (image.t - last_image_time_);
    frame.clock_offset = std::max(frame.clock_offset, least);
  }
  frame.t = image.t + frame.clock_offset;
  frame.pose = std::make_shared<VertexPose>();
  frame.speed_bias = std::make_shared<VertexSpeedBias>();
  if (!window_.frames.empty()) {
    const WindowFrame& last = window_.frames.back();
    frame.imu = Integrate(last, frame.t);
    const double t = frame.imu->SumDt();
    const Vec3 G(0, 0, options_.weights.gravity);
    const Qd q = last.pose->q();
    const Vec3 v = last.speed_bias->v();
    frame.pose->SetPose(q * frame.imu->Gamma(), last.pose->p() + t * v - 0.5 * t * t * G + q * frame.imu->Alpha());
    Vec9 v_ba_bg = last.speed_bias->GetEstimate();
    v_ba_bg.head<3>() = v - t * G + q * frame.imu->Beta();
    frame.speed_bias->SetEstimate(v_ba_bg);
  }
  window_.frames.push_back(std::move(frame));
  AppendTracks(image);
  const auto used =
      std::find_if(imu_.rbegin(), imu_.rend(), [&](const auto& r) { return r.t <= window_.frames.back().t; });
  if (used != imu_.rend()) imu_.erase(imu_.begin(), used.base() - 1);
}

void Estimator::AppendTracks(const CameraFrame& image) {
  const int frame = window_.frames.back().id;
  for (const TrackedPoint& point : image.tracks) {
    AppendToTrack({frame, image.t, point.x}, &window_.landmarks[point.id]);
  }
}

std::shared_ptr<Preintegration> Estimator::Integrate(const WindowFrame& from, double t1) const {
  std::vector<ImuReading> imu = imu_;
  // Before the first and beyond the last reading, that one holds on.
  if (imu.front().t > from.t) imu.insert(imu.begin(), {from.t, imu.front().acceleration, imu.front().gyroscope});
  if (imu.back().t < t1) imu.push_back({t1, imu.back().acceleration, imu.back().gyroscope});
  std::vector<ImuSample> samples = SamplesBetween(imu, from.t, t1);
  if (samples.size() == 2) {  // one step would give position and speed the same noise, and a singular covariance
    const double half = 0.5 * samples[1].dt;
    samples.insert(samples.begin() + 1, {half, 0.5 * (samples[0].acceleration + samples[1].acceleration),
                                         0.5 * (samples[0].gyroscope + samples[1].gyroscope)});
    samples[2].dt = half;
  }
  auto result = std::make_shared<Preintegration>(samples.at(0), from.speed_bias->b_a(), from.speed_bias->b_g(),
                                                 options_.imu_noise);
  for (size_t k = 1; k < samples.size(); ++k) result->Add(samples[k]);
  return result;
}

void Estimator::StartFrom(const StampedState& state, const MatXX& J) {
  if (J.cols() != 15) throw std::invalid_argument("Estimator::StartFrom: J must have 15 columns");
  Forget();
  given_ = {state, J};
}

// The window is the new frame alone.
void Estimator::BeginGiven() {
  const auto& [state, J] = *given_;
  const WindowFrame& frame = window_.frames.front();
  frame.pose->SetPose(state.T_W_B.q, state.T_W_B.p);
  Vec9 v_ba_bg;
  v_ba_bg << state.v_W, state.b_a, state.b_g;
  frame.speed_bias->SetEstimate(v_ba_bg);
  Prior prior{{frame.pose, frame.speed_bias}, {frame.pose->Parameters(), frame.speed_bias->Parameters()}, J, {}};
  prior.r0 = VecX::Zero(J.rows());
  window_.knows_place = (J * GaugeDirections(prior.vertices, {})).norm() > 0.0;
  window_.prior = std::make_shared<EdgePrior>(std::move(prior));
  last_p_ = frame.pose->p();
  last_sight_ = frame.t;
  given_.reset();
  started_ = true;
}

void Estimator::Start(const CameraFrame& image) {
  if (given_) return BeginGiven();
  if (const auto still = still_.AddFrame(image)) return StandStill(*still, image);
  if (MovedSinceStill(image)) {
    BeginTracking(options_.start_speed);
  } else if (window_.frames.size() >= kFramesToStartMoving && AlignWhileMoving()) {
    BeginTracking(options_.moving_start_speed);
  } else {
    policy_->NoteNewFrame(&window_);
    policy_->SlideWithoutEstimate(&window_);
  }
}

// The oldest frame still stands still, and the others have moved enough to see depth.
bool Estimator::MovedSinceStill(const CameraFrame& image) const {
  if (window_.frames.front().id != still_image_id_ || window_.frames.size() < kFramesToStart) return false;
  const auto motion = MedianMotion(still_image_, image);
  return motion && *motion * options_.weights.focal_length > options_.start_pixels;
}

void Estimator::BeginTracking(double speed_sigma) {
  window_.prior = StartPrior(window_, speed_sigma, options_);
  last_p_ = window_.frames.back().pose->p();
  last_sight_ = window_.frames.back().t;
  started_ = true;
}

bool Estimator::AlignWhileMoving() {
  std::vector<MovingFrame> frames;
  for (const WindowFrame& frame : window_.frames) frames.push_back({frame.t, {}, frame.imu});
  for (const auto& [id, landmark] : window_.landmarks) {
    for (const WindowObservation& seen : landmark.seen) {
      frames[static_cast<size_t>(window_.IndexOf(seen.frame))].tracks.push_back({id, seen.x});
    }
  }
  MovingStartOptions options;
  options.T_B_C = window_.T_B_C();
  options.focal_length = options_.weights.focal_length;
  options.pixel_sigma = options_.weights.pixel_sigma;
  options.gravity = options_.weights.gravity;
  options.b_a_sigma = options_.start_bias_accelerometer;
  const MovingStart start = StartMoving(frames, options);
  if (start.failure != StartFailure::kNone) return false;
  for (size_t k = 0; k < start.states.size(); ++k) {
    const StampedState& state = start.states[k];
    window_.frames[k].pose->SetPose(state.T_W_B.q, state.T_W_B.p);
    Vec9 v_ba_bg;
    v_ba_bg << state.v_W, state.b_a, state.b_g;
    window_.frames[k].speed_bias->SetEstimate(v_ba_bg);
  }
  return true;
}

// While it stands, the window is its newest frame alone.
void Estimator::StandStill(const StillState& still, const CameraFrame& image) {
  while (window_.frames.size() > 1) SlideWindow(MarginalizationFlag::kOld, &window_);
  const WindowFrame& frame = window_.frames.front();
  frame.pose->SetPose(still.q_W_B, Vec3::Zero());
  Vec9 v_ba_bg;
  v_ba_bg << Vec3::Zero(), still.b_a, still.b_g;
  frame.speed_bias->SetEstimate(v_ba_bg);
  still_image_ = image;
  still_image_id_ = frame.id;
}

// First estimates in full: the minimum is found as ever, since constrained Jacobians J' need not go downhill from afar;
// then two steps with them lead to where their own gradient vanishes, Σ J'ᵀ W r = 0, which lies nearby and in which no
// information on the gauge takes part. They are Gauss-Newton's, and so need somebody to hold the gauge.
Summary Estimator::Solve() {
  const auto uses = [&](const Window& w, const WindowLandmark& l) { return policy_->Uses(w, l); };
  const bool full = options_.first_estimates == FirstEstimates::kFull;
  if (full) window_.first_estimates = FirstEstimates::kPriorOnly;
  BuildGraph(options_.weights, uses, &window_);
  Summary summary = optimizer_.Solve(policy_->Options());
  if (!full) return summary;

  RemoveFailures(&window_);
  window_.first_estimates = FirstEstimates::kFull;
  BuildGraph(options_.weights, uses, &window_);
  std::shared_ptr<Edge> gauge;
  if (!window_.knows_place && !window_.gauge) {
    gauge = HoldGauge(window_.frames.front().pose, 1e8);
    window_.graph.AddEdge(gauge);
  }
  SolveOptions options;
  options.algorithm = Algorithm::kGaussNewton;
  options.max_iterations = 2;
  optimizer_.Solve(options);
  if (gauge) window_.graph.RemoveEdge(gauge);
  return summary;
}

FrameReport Estimator::Track(const CameraFrame& image) {
  FrameReport report;
  Reintegrate();
  policy_->NoteNewFrame(&window_);
  TriangulateLandmarks(&window_);
  report.solve = Solve();
  policy_->AfterSolve(&window_);
  const auto& vertices = window_.graph.Vertices();
  report.landmarks = static_cast<int>(std::count_if(
      vertices.begin(), vertices.end(), [](const auto& vertex) { return vertex->GetRole() == Role::kLandmark; }));
  const Failure failure = DetectFailure(window_, last_p_);
  if (failure != Failure::kNone) return Restart(failure);
  if (options_.report_covariance) report.pose_covariance = PoseCovariance(window_, window_.frames.back());
  RemoveFailures(&window_);
  RemoveOutliers(options_.max_outlier_pixels / options_.weights.focal_length, &window_);
  if (RejectsImages(image)) return Restart(Failure::kImagesRejected);
  last_p_ = window_.frames.back().pose->p();
  report.status = FrameReport::Status::kTracking;
  report.state = window_.StateOf(window_.frames.back());
  policy_->Slide(&window_);
  return report;
}

// When images and IMU contradict each other, the outliers' removal takes all that the images say, and nothing would ever
// end the dead reckoning: landmarks come and go, but none lasts.
bool Estimator::RejectsImages(const CameraFrame& image) {
  const auto lasting = std::count_if(window_.landmarks.begin(), window_.landmarks.end(), [](const auto& entry) {
    return entry.second.inverse_depth && entry.second.seen.size() >= kLastingImages;
  });
  if (lasting >= kFewLandmarks || image.tracks.size() < kPlentyOfTracks) last_sight_ = image.t;
  return image.t - last_sight_ > options_.max_rejecting;
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

}  // namespace ch5
