#include "ch5_backend/window/estimator.h"

#include <algorithm>
#include <map>

#include "ch5_backend/window/initialization.h"
#include "ch5_backend/window/landmarks.h"

namespace ch5 {
namespace {

// Images between standing still and the first solve; images to start from while moving.
constexpr size_t kFramesToStart = 4, kFramesToStartMoving = 8;

std::string At(double t) { return " at t = " + std::to_string(t) + " s"; }

// σ of what a start knows, as a prior on the oldest frame's speed and biases.
std::shared_ptr<EdgePrior> PriorOn(const std::shared_ptr<VertexSpeedBias>& speed_bias, double speed,
                                   const EstimatorOptions& options) {
  Vec9 sigma;
  sigma << Vec3::Constant(speed), Vec3::Constant(options.start_bias_accelerometer),
      Vec3::Constant(options.start_bias_gyroscope);
  Prior prior;
  prior.vertices = {speed_bias};
  prior.x0 = {speed_bias->GetEstimate()};
  prior.J = sigma.cwiseInverse().asDiagonal();
  prior.r0 = VecX::Zero(9);
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
  if (next_frame_ > 0 && frame.t <= last_image_.t) {
    throw MeasurementError("the image" + At(frame.t) + (frame.t == last_image_.t ? " repeats" : " is before") +
                           " the one" + At(last_image_.t));
  }
  for (const TrackedPoint& point : frame.tracks) {
    if (!point.x.allFinite()) {
      throw MeasurementError("track " + std::to_string(point.id) + " of the image" + At(frame.t) + " is not finite");
    }
  }
}

FrameReport Estimator::AddFrame(const CameraFrame& frame) {
  Check(frame);
  AppendFrame(frame);
  FrameReport report;
  if (!started_) Start(frame);
  if (started_) report = Track();
  last_image_ = frame;
  return report;
}

// The new frame's states, as the IMU predicts them:
//   q_j = q_i γ,   v_j = v_i − G t + R_i β,   p_j = p_i + v_i t − ½ G t² + R_i α
void Estimator::AppendFrame(const CameraFrame& image) {
  WindowFrame frame;
  frame.id = next_frame_++;
  frame.clock_offset = TimeOffset();
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
  std::map<int, Vec2> before;
  for (const TrackedPoint& point : last_image_.tracks) before[point.id] = point.x;
  for (const TrackedPoint& point : image.tracks) {
    WindowObservation seen{window_.frames.back().id, point.x, Vec2::Zero()};
    const auto last = before.find(point.id);
    if (last != before.end()) seen.velocity = (point.x - last->second) / (image.t - last_image_.t);
    window_.landmarks[point.id].seen.push_back(seen);
  }
}

std::shared_ptr<Preintegration> Estimator::Integrate(const WindowFrame& from, double t1) const {
  std::vector<ImuReading> imu = imu_;
  if (imu.empty()) throw MeasurementError("no IMU reading yet for the image" + At(t1));
  // Where readings are missing, the nearest one holds on.
  if (imu.front().t > from.t) imu.insert(imu.begin(), {from.t, imu.front().acceleration, imu.front().gyroscope});
  if (imu.back().t < t1) imu.push_back({t1, imu.back().acceleration, imu.back().gyroscope});
  const std::vector<ImuSample> samples = SamplesBetween(imu, from.t, t1);
  auto result = std::make_shared<Preintegration>(samples.at(0), from.speed_bias->b_a(), from.speed_bias->b_g(),
                                                 options_.imu_noise);
  for (size_t k = 1; k < samples.size(); ++k) result->Add(samples[k]);
  return result;
}

void Estimator::Start(const CameraFrame& image) {
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
  window_.prior = PriorOn(window_.frames.front().speed_bias, speed_sigma, options_);
  last_p_ = window_.frames.back().pose->p();
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

FrameReport Estimator::Track() {
  FrameReport report;
  Reintegrate();
  policy_->NoteNewFrame(&window_);
  TriangulateLandmarks(&window_);
  BuildGraph(
      options_.weights, [&](const Window& w, const WindowLandmark& l) { return policy_->Uses(w, l); }, &window_);
  report.solve = optimizer_.Solve(policy_->Options());
  policy_->AfterSolve(&window_);
  report.failure = DetectFailure(window_, last_p_);
  if (report.failure != Failure::kNone) {
    ++restarts_;
    Forget();
    report.status = FrameReport::Status::kRestarted;
    return report;
  }
  const auto& vertices = window_.graph.Vertices();
  report.landmarks = static_cast<int>(std::count_if(
      vertices.begin(), vertices.end(), [](const auto& vertex) { return vertex->GetRole() == Role::kLandmark; }));
  RemoveFailures(&window_);
  RemoveOutliers(options_.max_outlier_pixels / options_.weights.focal_length, &window_);
  last_p_ = window_.frames.back().pose->p();
  report.status = FrameReport::Status::kTracking;
  report.state = window_.StateOf(window_.frames.back());
  policy_->Slide(&window_);
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

}  // namespace ch5
