/// The initialization of the estimator: static, dynamic, or from a given state.

#include <algorithm>
#include <cmath>
#include <tuple>

#include "ch5_backend/consistency/gauge_directions.h"
#include "ch5_backend/window/estimator.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/start/dynamic_initialization.h"
#include "ch5_backend/window/start_values.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5 {
namespace {

// Images from a standstill to the first solve, and images of a dynamic initialization.
constexpr size_t kFramesToStart = 4, kFramesToStartMoving = 8;
constexpr size_t kNoLandmarks = std::numeric_limits<size_t>::max();  // seen so many times

// After a start from standstill, or a change of speed or direction, the scale is known by then [s].
constexpr double kScaleReportDelay = 1.0;

// The fraction of the landmarks' observations within 3 σ.
double InliersOf(const Graph& graph) {
  double observations = 0.0, inliers = 0.0;
  for (const auto& edge : graph.Edges()) {
    if (edge->Vertices().front()->GetRole() != Role::kLandmark) continue;
    edge->ComputeResidual();
    ++observations;
    if (edge->Chi2() < 9.0) ++inliers;
  }
  return inliers / std::max(1.0, observations);
}

// Of a row, with losses.
double MeanChi2(const std::vector<std::shared_ptr<Edge>>& edges) {
  int rows = 0;
  for (const auto& edge : edges) rows += edge->ResidualDimension();
  return 2.0 * Cost(edges) / rows;
}

}  // namespace

void Estimator::TryToStart(const Image& image) {
  if (given_start_) return StartFromGivenState();
  if (const auto standstill = standstill_detector_.AddFrame(image, TimeOffset())) return RestAt(*standstill, image);
  const auto& frames = window_.frames;
  const auto moved = PixelsSinceStandstill(image);
  // Frames were left out to keep the one at rest.
  const bool has_waited = frames.back().id - frames.front().id >= static_cast<int>(frames.size());
  if (moved && *moved > options_.start_pixels && frames.size() >= kFramesToStart &&
      (!has_waited || KnowsScaleSinceStandstill())) {
    BeginAt(options_.start_speed, has_waited);
  } else if (InitializeInMotion()) {
    BeginAt(options_.moving_start_speed, false);
  } else {
    SlideBeforeStart(moved && *moved < options_.start_pixels && SecondsInWindow() < options_.weights.max_imu_seconds);
  }
}

void Estimator::StartFrom(const StampedState& state, const MatXX& J) {
  if (J.cols() != 15) {
    throw std::invalid_argument("Estimator::StartFrom: J must have 15 columns, got " + std::to_string(J.cols()));
  }
  if (!J.allFinite()) throw std::invalid_argument("Estimator::StartFrom: J holds a number that is not finite");
  if (!state.T_W_B.p.allFinite() || !state.T_W_B.q.coeffs().allFinite() || !state.v_W.allFinite() ||
      !state.b_a.allFinite() || !state.b_g.allFinite()) {
    throw std::invalid_argument("Estimator::StartFrom: the state holds a number that is not finite");
  }
  Reset();
  given_start_ = {state, J};
}

// The window consists of the new frame only.
void Estimator::StartFromGivenState() {
  const auto& [state, J] = *given_start_;
  const Frame& frame = window_.frames.front();
  Window::SetState(state, frame);
  Prior prior{{frame.pose, frame.speed_bias}, {frame.pose->Parameters(), frame.speed_bias->Parameters()}, J, {}};
  prior.r0 = VecX::Zero(J.rows());
  const double along_gauge = (J * GaugeDirections(prior.vertices, {})).norm();
  window_.prior_fixes_gauge = along_gauge > 1e-9 * J.norm();  // less is rounding
  window_.prior = std::make_shared<EdgePrior>(std::move(prior));
  given_start_.reset();
  BeginTracking();
}

// At rest the window consists of its newest frame only.
void Estimator::RestAt(const StandstillState& standstill, const Image& image) {
  start_message_ = "at rest, waiting for motion";
  while (window_.frames.size() > 1) SlideWindow(MarginalizationFlag::kOld, &window_);
  const Frame& frame = window_.frames.front();
  StampedState state;
  state.T_W_B.q = standstill.q_W_B;
  state.b_a = standstill.b_a;
  state.b_g = standstill.b_g;
  Window::SetState(state, frame);
  standstill_image_ = image;
  standstill_frame_ = frame.id;
}

// The images' motion since the oldest frame, if it is at rest and its tracks last.
std::optional<double> Estimator::PixelsSinceStandstill(const Image& image) const {
  if (window_.frames.front().id != standstill_frame_) return std::nullopt;
  const auto motion = TypicalMotion(standstill_image_, image);
  if (!motion) return std::nullopt;
  return *motion * options_.calibration.FocalLength();
}

double Estimator::SecondsInWindow() const { return window_.frames.back().t - window_.frames.front().t; }

// Long after a standstill its speed of about zero determines the scale only if the speed has become large beside what the IMU
// adds to its error, gravity being known as it was measured at rest.
bool Estimator::KnowsScaleSinceStandstill() const {
  constexpr double kSoon = 1.5;  // [s]
  constexpr double kMost = 0.1;  // relative error, as of a start in motion
  const double sigma = std::hypot(options_.start_speed, kForceAtRestSigma * SecondsInWindow());
  return SecondsInWindow() < kSoon || sigma < kMost * window_.frames.back().speed_bias->v().norm();
}

bool Estimator::InitializeInMotion() {
  if (window_.frames.size() < kFramesToStartMoving) {
    start_message_ = (window_.HasStereoDepth() ? "not yet " : "neither a second at rest nor ") +
                     std::to_string(kFramesToStartMoving) +
                     (window_.HasStereoDepth() ? " images, but " : " images in motion yet, but ") +
                     std::to_string(window_.frames.size());
    return false;
  }
  // An attempt takes as long as several solves: at most ten a second, so that it keeps pace with fast cameras.
  constexpr double kJitter = 0.9;  // of time stamps, which must not cost another image
  if (window_.frames.back().t < last_attempt_ + kJitter * kLeastSpacing) return false;
  last_attempt_ = window_.frames.back().t;
  std::vector<InitializationImage> frames;
  for (const Frame& frame : window_.frames) frames.push_back({frame.t, {}, frame.imu});
  for (const auto& [id, landmark] : window_.landmarks) {
    for (const WindowObservation& seen : landmark.seen) {
      InitializationImage& frame = frames[static_cast<size_t>(window_.IndexOf(seen.frame))];
      frame.tracks.push_back({id, seen.x});
      if (seen.second) frame.tracks1.push_back({id, seen.second->x});
    }
  }
  DynamicInitializationOptions options;
  options.T_B_C = window_.T_B_C();
  options.focal_length = options_.calibration.FocalLength();
  options.pixel_sigma = options_.weights.pixel_sigma;
  options.gravity = options_.calibration.gravity;
  options.b_a_sigma = options_.start_bias_accelerometer;
  if (window_.HasStereoDepth()) options.camera1 = options_.calibration.camera1;
  options.wants_shape = options_.own_edges != nullptr;
  const DynamicInitialization start = InitializeDynamically(frames, options);
  start_message_ = "no start in motion: " + start.message;
  if (start.failure != InitializationFailure::kNone) return !start.shape.empty() && FindScaleByOwnEdges(start.shape);
  for (size_t k = 0; k < start.states.size(); ++k) Window::SetState(start.states[k], window_.frames[k]);
  return true;
}

// At steady speed images and IMU leave the scale unknown, but one's own edges may tell it. Of scales a factor of √2 apart the
// one that they fit best is refined together with all else; it counts if it is known as well as in any start in motion.
bool Estimator::FindScaleByOwnEdges(const std::vector<StampedState>& shape) {
  constexpr double kAnySpeed = 1e3;  // σ [m/s]
  constexpr double kMostOwnChi2 = 4.0;
  BuildWithOwnEdges(kNoLandmarks);
  if (window_.own_edges.empty()) return false;
  std::vector<std::pair<std::shared_ptr<Vertex>, VecX>> before;
  for (const auto& vertex : window_.graph.Vertices()) before.emplace_back(vertex, vertex->Parameters());

  SetStates(shape, ScaleThatOwnEdgesFit(shape));
  window_.prior = StartPrior(window_, kAnySpeed, options_);
  TriangulateLandmarks(&window_);
  BuildWithOwnEdges(3);
  SolveWithGaugeHeld({});

  const DynamicInitializationOptions limits;
  if (MeanChi2(window_.own_edges) <= kMostOwnChi2 && InliersOf(window_.graph) >= limits.least_inliers) {
    if (const auto sigma = ScaleSigma(window_); sigma && *sigma <= limits.largest_scale_sigma) return true;
  }
  for (const auto& [vertex, x] : before) vertex->Parameters() = x;
  for (auto& [id, landmark] : window_.landmarks) landmark.inverse_depth = nullptr;
  window_.prior = nullptr;
  return false;
}

double Estimator::ScaleThatOwnEdgesFit(const std::vector<StampedState>& shape) {
  constexpr int kHalfOctaves = 12;  // in either direction
  const auto hold_frames = [&](bool hold) {
    for (const Frame& frame : window_.frames) {
      frame.pose->SetFixed(hold);
      frame.speed_bias->SetFixed(hold);
    }
  };
  double least = std::numeric_limits<double>::infinity(), best = 1.0;
  for (int n = 0; n <= 2 * kHalfOctaves; ++n) {  // from 1 outward: own edges that say nothing leave it there
    const double scale = std::exp2(0.5 * (n % 2 == 0 ? n / 2 : -(n + 1) / 2));
    SetStates(shape, scale);
    BuildWithOwnEdges(kNoLandmarks);
    hold_frames(true);
    optimizer_.Solve();  // for vertices of one's own
    hold_frames(false);
    const double cost = Cost(window_.own_edges);
    if (cost < least) std::tie(least, best) = std::pair(cost, scale);
  }
  return best;
}

void Estimator::BuildWithOwnEdges(size_t least_views) {
  const auto uses = [&](const Window&, const WindowLandmark& landmark) { return landmark.seen.size() >= least_views; };
  BuildGraph(options_.weights, uses, &window_, options_.own_edges);
}

void Estimator::SetStates(const std::vector<StampedState>& shape, double scale) {
  for (size_t k = 0; k < shape.size(); ++k) {
    StampedState state = shape[k];
    state.T_W_B.p *= scale;
    state.v_W *= scale;
    Window::SetState(state, window_.frames[k]);
  }
  if (segment_ > 0 && last_state_) LayUponLastSegment();
}

// All policies start from the same frames, a tenth of a second apart: a window long enough to distinguish gravity from acceleration,
// which short tracks still cross. Where such windows do not start, as nothing accelerates for so long, longer ones are tried.
// A frame at rest is kept until the images have moved: driving off straight ahead offers no other start.
void Estimator::SlideBeforeStart(bool keeps_oldest) {
  constexpr double kMostSpacing = 0.4;
  const auto& frames = window_.frames;
  const size_t n = frames.size();
  const size_t most = std::max(policy_->MostFrames(), kFramesToStartMoving);
  if (n <= most) return;
  const bool keep = !keeps_oldest && frames[n - 2].t - frames[n - 3].t >= start_spacing_;
  SlideWindow(keep ? MarginalizationFlag::kOld : MarginalizationFlag::kSecondNew, &window_);
  if (!keep || ++frames_at_spacing_ < most) return;
  frames_at_spacing_ = 0;
  start_spacing_ = start_spacing_ < kMostSpacing ? 2.0 * start_spacing_ : kLeastSpacing;
}

// If the window is smaller than a start needs, the newest frames are kept, and the one in which gravity is known.
void Estimator::BeginAt(double start_speed, bool knows_gravity) {
  const auto leaves = knows_gravity ? MarginalizationFlag::kSecondNew : MarginalizationFlag::kOld;
  while (window_.frames.size() > policy_->MostFrames() + 1) SlideWindow(leaves, &window_);
  if (segment_ > 0 && last_state_) LayUponLastSegment();
  window_.prior = StartPrior(window_, start_speed, options_, knows_gravity);
  BeginTracking();
}

// The initialization leaves position and yaw at zero in its first frame. What has happened since the last state that was
// given out is not known, but a place near it is a better guess than the origin of long ago.
void Estimator::LayUponLastSegment() {
  const Qd Q = last_state_->T_W_B.q * window_.frames.front().pose->q().conjugate();
  const Qd turn = TwistAboutGravity(Q);
  const Vec3 p0 = window_.frames.front().pose->p();
  for (const Frame& frame : window_.frames) {
    StampedState state = window_.StateOf(frame);
    state.T_W_B = {turn * state.T_W_B.q, turn * (state.T_W_B.p - p0) + last_state_->T_W_B.p};
    state.v_W = turn * state.v_W;
    Window::SetState(state, frame);
  }
}

void Estimator::BeginTracking() {
  last_p_ = window_.frames.back().pose->p();
  last_time_with_landmarks_ = window_.frames.back().t - window_.frames.back().clock_offset;
  if (!window_.HasStereoDepth()) scale_report_time_ = window_.frames.back().t + kScaleReportDelay;
  track_ages_.clear();
  started_ = true;
  // From now on the images' motion since the rest began tells too, and a hovering vehicle sways.
  constexpr double kMoreChange = 3.0;
  StandstillOptions rest = options_.standstill;
  rest.change *= kMoreChange;
  standstill_detector_ = StandstillDetector(options_.calibration, rest);
}

}  // namespace ch5
