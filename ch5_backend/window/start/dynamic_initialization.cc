#include "ch5_backend/window/start/dynamic_initialization.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>

#include "ch5_backend/consistency/position_yaw_prior.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/math/so3.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "ch5_backend/types/visual/edge_stereo.h"
#include "ch5_backend/window/start/closed_form.h"

namespace ch5 {
namespace {

// Nearer points, and those behind the camera, take no part [m].
constexpr double kLeastPointDepth = 0.1;

// Of the points on average, where nothing tells the scale [m].
constexpr double kShapeDepth = 5.0;

// By ascending id.
std::vector<FeatureTrack> CollectTracks(const std::vector<InitializationImage>& frames, std::vector<int>* ids) {
  std::map<int, FeatureTrack> by_id;
  for (size_t k = 0; k < frames.size(); ++k) {
    for (const TrackedPoint& point : frames[k].tracks) by_id[point.id].views.push_back({static_cast<int>(k), point.x});
  }
  std::vector<FeatureTrack> tracks;
  for (auto& [id, track] : by_id) {
    ids->push_back(id);
    tracks.push_back(std::move(track));
  }
  return tracks;
}

// What camera 1 sees of the tracks, behind camera 0's view of the same image.
// @return how many tracks it sees
int AddSecondViews(const std::vector<InitializationImage>& frames, const std::vector<int>& ids,
                   std::vector<FeatureTrack>* tracks) {
  std::vector<std::map<int, Vec2>> seen(frames.size());
  for (size_t k = 0; k < frames.size(); ++k) {
    for (const TrackedPoint& point : frames[k].tracks1) seen[k][point.id] = point.x;
  }
  int count = 0;
  for (size_t n = 0; n < ids.size(); ++n) {
    std::vector<FeatureTrack::View> views;
    for (const FeatureTrack::View& view : (*tracks)[n].views) {
      views.push_back(view);
      const auto& image = seen[static_cast<size_t>(view.frame)];
      if (const auto point = image.find(ids[n]); point != image.end()) views.push_back({view.frame, point->second, 1});
    }
    if (views.size() > (*tracks)[n].views.size()) ++count;
    (*tracks)[n].views = std::move(views);
  }
  return count;
}

// Two views determine a depth; only a third one constrains the scale of the motion.
void RemoveShortTracks(std::vector<FeatureTrack>* tracks) {
  const auto is_short = [](const FeatureTrack& track) { return track.views.size() < 3; };
  tracks->erase(std::remove_if(tracks->begin(), tracks->end(), is_short), tracks->end());
}

// The largest angle between a track's first ray and another, rotation compensated; the median over the tracks.
double MedianParallax(const std::vector<FeatureTrack>& tracks, const std::vector<Preintegration>& imu,
                      const Qd& R_B_C) {
  std::vector<Qd> R{Qd::Identity()};
  for (const Preintegration& step : imu) R.push_back(R.back() * step.Gamma());
  std::vector<double> angles;
  for (const FeatureTrack& track : tracks) {
    const auto ray = [&](const FeatureTrack::View& view) -> Vec3 {
      return (R[static_cast<size_t>(view.frame)] * (R_B_C * view.x.homogeneous())).normalized();
    };
    double largest = 0.0;
    for (const auto& view : track.views) {
      if (view.camera == 0) largest = std::max(largest, ray(view).cross(ray(track.views[0])).norm());
    }
    angles.push_back(largest);
  }
  return Median(angles);
}

// The window as a graph, at the closed form's states.
struct StartGraph {
  Graph graph;
  std::vector<std::shared_ptr<VertexPose>> poses;
  std::vector<std::shared_ptr<VertexSpeedBias>> speed_biases;
  std::vector<std::shared_ptr<Edge>> observations;
  std::shared_ptr<VertexPose> T_B_C0, T_B_C1;  // fixed, as the time offset is; null with one camera
  std::shared_ptr<VertexScalar> time_offset;
};

void AddBody(const ClosedForm& start, const std::vector<Preintegration>& imu,
             const DynamicInitializationOptions& options, StartGraph* g) {
  for (const StampedState& state : start.states) {
    Vec9 v_ba_bg;
    v_ba_bg << state.v_W, state.b_a, state.b_g;
    g->poses.push_back(std::make_shared<VertexPose>(state.T_W_B.q, state.T_W_B.p));
    g->speed_biases.push_back(std::make_shared<VertexSpeedBias>(v_ba_bg));
    g->graph.AddVertex(g->poses.back());
    g->graph.AddVertex(g->speed_biases.back());
  }
  for (size_t k = 0; k < imu.size(); ++k) {
    g->graph.AddEdge(std::make_shared<EdgeImu>(g->poses[k], g->speed_biases[k], g->poses[k + 1], g->speed_biases[k + 1],
                                               std::make_shared<Preintegration>(imu[k]), Vec3(0, 0, options.gravity)));
  }
  Prior zero_b_a{{g->speed_biases[0]}, {VecX::Zero(9)}, MatXX::Zero(3, 9), VecX::Zero(3)};
  zero_b_a.J.middleCols<3>(3).diagonal().setConstant(1.0 / options.b_a_sigma);
  g->graph.AddEdge(std::make_shared<EdgePrior>(zero_b_a));
}

void AddSecondCamera(const DynamicInitializationOptions& options, StartGraph* g) {
  const auto fixed = [&](auto vertex) {
    vertex->SetFixed();
    g->graph.AddVertex(vertex);
    return vertex;
  };
  const Transform &T_B_C0 = options.T_B_C, &T_B_C1 = options.camera1->T_B_C;
  g->T_B_C0 = fixed(std::make_shared<VertexPose>(T_B_C0.q, T_B_C0.p));
  g->T_B_C1 = fixed(std::make_shared<VertexPose>(T_B_C1.q, T_B_C1.p));
  g->time_offset = fixed(std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)));
}

std::shared_ptr<Edge> ViewEdge(const std::shared_ptr<VertexInverseDepth>& inverse_depth, const FeatureTrack::View& host,
                               const FeatureTrack::View& view, const Transform& T_B_C, const StartGraph& g) {
  const auto &T_W_Bi = g.poses[static_cast<size_t>(host.frame)], &T_W_Bj = g.poses[static_cast<size_t>(view.frame)];
  if (view.camera == 0) return std::make_shared<EdgeReprojection>(inverse_depth, T_W_Bi, T_W_Bj, host.x, view.x, T_B_C);
  const MovingPoint from{host.x}, to{view.x};
  if (view.frame == host.frame) {
    return std::make_shared<EdgeStereoHost>(inverse_depth, g.T_B_C0, g.T_B_C1, g.time_offset, from, to);
  }
  return std::make_shared<EdgeStereo>(inverse_depth, T_W_Bi, T_W_Bj, g.T_B_C0, g.T_B_C1, g.time_offset, from, to);
}

void AddTracks(const ClosedForm& start, const std::vector<FeatureTrack>& tracks,
               const DynamicInitializationOptions& options, StartGraph* g) {
  const auto information = [&](double focal_length) { return std::pow(focal_length / options.pixel_sigma, 2); };
  const double w = information(options.focal_length);
  const double w1 = options.camera1 ? information(options.camera1->FocalLength()) : w;
  const auto loss = std::make_shared<CauchyLoss>(1.0);
  for (size_t k = 0; k < tracks.size(); ++k) {
    if (!(start.depths[k] > kLeastPointDepth)) continue;
    auto inverse_depth = std::make_shared<VertexInverseDepth>(1.0 / start.depths[k]);
    g->graph.AddVertex(inverse_depth);
    const auto& host = tracks[k].views.front();
    for (size_t v = 1; v < tracks[k].views.size(); ++v) {
      const auto& view = tracks[k].views[v];
      const std::shared_ptr<Edge> edge = ViewEdge(inverse_depth, host, view, options.T_B_C, *g);
      edge->SetIsotropicInformation(view.camera == 0 ? w : w1);
      edge->SetLossFunction(loss);
      g->graph.AddEdge(edge);
      g->observations.push_back(edge);
    }
  }
}

// σ of the way from the first image to the last, relative to it, and of gravity's direction, by all measurements together:
// the closed form took the IMU for exact. Position and yaw of the first image are held.
void ComputeUncertainty(const StartGraph& g, ClosedForm* start) {
  start->scale_sigma = start->gravity_sigma = std::numeric_limits<double>::infinity();
  std::vector<std::shared_ptr<Vertex>> others;
  for (const auto& vertex : g.graph.Vertices()) {
    if (vertex != g.poses.front() && vertex != g.poses.back() && !vertex->IsFixed()) others.push_back(vertex);
  }
  std::vector<std::shared_ptr<Edge>> edges = g.graph.Edges();
  edges.push_back(MakePositionYawPrior(g.poses.front(), 1e8));
  const MatXX H = EliminateVertices(edges, others).H;  // of the first pose, then the last
  const Eigen::LLT<MatXX> factor(H);
  if (factor.info() != Eigen::Success) return;
  const MatXX covariance = factor.solve(MatXX::Identity(H.rows(), H.cols()));
  const Vec3 way = g.poses.back()->p() - g.poses.front()->p();
  start->scale_sigma = std::sqrt(way.dot(covariance.block<3, 3>(6, 6) * way)) / way.squaredNorm();
  start->gravity_sigma = std::sqrt(covariance.block<3, 3>(3, 3).trace());
}

// While the acceleration a stays the same, a second motion explains the specific force  f = a + g ẑ:  one k times as large,
// in which gravity has another direction.  ‖f − k a‖ = g:  k = 1 + 2 g a_z/‖a‖².  The closed form may have found either.
// For a motion whose points lie behind the camera, k < 0, the one that sees them in front.
// @return nullopt if the two are too unlike to be taken for each other
std::optional<ClosedForm> SecondSolution(const ClosedForm& start, const std::vector<Preintegration>& imu, double g) {
  constexpr double kMost = 30.0;
  double seconds = 0.0;
  for (const Preintegration& step : imu) seconds += step.SumDt();
  const Vec3 a = (start.states.back().v_W - start.states.front().v_W) / seconds;
  const double k = 1.0 + 2.0 * g * a.z() / a.squaredNorm();
  if (!(std::abs(k) > 1.0 / kMost && std::abs(k) < kMost)) return std::nullopt;
  const Qd turn = RotationBetween(a + g * Vec3::UnitZ() - k * a, Vec3::UnitZ());
  ClosedForm second = start;
  for (StampedState& state : second.states) {
    state.T_W_B = {turn * state.T_W_B.q, turn * (k * state.T_W_B.p)};
    state.v_W = turn * (k * state.v_W);
  }
  for (double& depth : second.depths) depth *= k;
  return second;
}

// How well a motion fits.
struct Fit {
  double inliers = 0.0;  // the fraction of the observations within 3 σ
  double cost = 0.0;     // those that take no part count as 3 σ
  bool has_points = false;
};

// Solves for all states jointly; the gauge is free, which the damping copes with.
Fit Refine(const std::vector<FeatureTrack>& tracks, const std::vector<Preintegration>& imu,
           const DynamicInitializationOptions& options, ClosedForm* start) {
  StartGraph g;
  AddBody(*start, imu, options, &g);
  if (options.camera1) AddSecondCamera(options, &g);
  AddTracks(*start, tracks, options, &g);
  SparseOptimizer optimizer(&g.graph);
  SolveOptions solve;
  solve.max_iterations = 50;
  const double cost = optimizer.Solve(solve).final_cost;
  size_t total = 0, good = 0;
  for (const FeatureTrack& track : tracks) total += track.views.size() - 1;
  for (const auto& edge : g.observations) {
    edge->ComputeResidual();
    if (edge->Chi2() < 9.0) ++good;
  }
  try {
    ComputeUncertainty(g, start);
  } catch (const GraphError&) {  // a number is not finite: nothing is known
  }
  const Vec3 origin = g.poses[0]->p();
  for (size_t k = 0; k < g.poses.size(); ++k) {
    StampedState& state = start->states[k];
    state.T_W_B = {g.poses[k]->q(), g.poses[k]->p() - origin};
    state.v_W = g.speed_biases[k]->v();
    state.b_a = g.speed_biases[k]->b_a();
    state.b_g = g.speed_biases[k]->b_g();
  }
  const double left_out = 0.5 * std::log(1.0 + 9.0) * static_cast<double>(total - g.observations.size());
  return {static_cast<double>(good) / static_cast<double>(total), cost + left_out, !g.observations.empty()};
}

// Copies, integrated without accelerometer bias.
std::vector<Preintegration> CopyImu(const std::vector<InitializationImage>& frames) {
  std::vector<Preintegration> imu;
  for (size_t k = 1; k < frames.size(); ++k) {
    if (!frames[k].imu)
      throw std::invalid_argument("InitializeDynamically: image " + std::to_string(k) + " has no IMU");
    imu.push_back(*frames[k].imu);
    imu.back().Reintegrate(Vec3::Zero(), imu.back().BiasGyroscope());
  }
  return imu;
}

}  // namespace

std::string ToString(InitializationFailure failure) {
  switch (failure) {
    case InitializationFailure::kNone: return "started";
    case InitializationFailure::kTooFewFrames: return "too few frames";
    case InitializationFailure::kTooFewTracks: return "too few tracks";
    case InitializationFailure::kTooLittleParallax: return "too little parallax";
    case InitializationFailure::kTooLittleExcitation: return "too little excitation";
    case InitializationFailure::kInconsistent: return "images and IMU disagree";
  }
  return "unknown";
}

namespace {

// Each step fills its part of the result; where it fails it says so and returns false.
class DynamicInitializer {
 public:
  explicit DynamicInitializer(const DynamicInitializationOptions& options) : options_(options) {}

  DynamicInitialization Run(const std::vector<InitializationImage>& frames) {
    if (!EstimateRotations(frames) || !MeasureParallax()) return result_;
    if (SolveLinearProblem() && RefineAll()) {
      for (size_t k = 0; k < frames.size(); ++k) start_.states[k].t = frames[k].t;
      result_.states = std::move(start_.states);
      result_.message = ToString(InitializationFailure::kNone);
    } else if (options_.wants_shape) {
      ClosedFormOptions options = LinearProblem();
      options.mean_depth = kShapeDepth;
      start_ = SolveClosedForm(tracks_, imu_, options);
      if (start_.gravity_sigma <= options_.largest_gravity_sigma) result_.shape = std::move(start_.states);
    }
    return result_;
  }

 private:
  bool Fail(InitializationFailure failure, const char* format, double value, double limit = 0.0) {
    char text[120];
    std::snprintf(text, sizeof(text), format, value, limit);
    result_.failure = failure;
    result_.message = ToString(failure) + ": " + text;
    return false;
  }

  bool EstimateRotations(const std::vector<InitializationImage>& frames) {
    constexpr size_t kLeastFrames = 4;
    if (frames.size() < kLeastFrames) {
      return Fail(InitializationFailure::kTooFewFrames, "%g, at least %g are needed",
                  static_cast<double>(frames.size()), kLeastFrames);
    }
    imu_ = CopyImu(frames);
    std::vector<int> ids;
    tracks_ = CollectTracks(frames, &ids);
    EstimateGyroscopeBias(options_.T_B_C.q, Sigma(), &tracks_, &imu_);
    if (options_.camera1) knows_scale_ = AddSecondViews(frames, ids, &tracks_) >= options_.least_tracks;
    RemoveShortTracks(&tracks_);
    const auto count = static_cast<double>(tracks_.size());
    return count >= options_.least_tracks || Fail(InitializationFailure::kTooFewTracks,
                                                  "%g seen three times, %g are needed", count, options_.least_tracks);
  }

  bool MeasureParallax() {
    result_.parallax = options_.focal_length * MedianParallax(tracks_, imu_, options_.T_B_C.q);
    if (knows_scale_ || result_.parallax >= options_.least_parallax) return true;
    constexpr double kStill = 1.0;  // [px]
    return Fail(InitializationFailure::kTooLittleParallax,
                result_.parallax < kStill ? "the camera stands still, a median of %.1f px, %g px are needed"
                                          : "a median of %.1f px, %g px are needed; move sideways",
                result_.parallax, options_.least_parallax);
  }

  ClosedFormOptions LinearProblem() const {
    ClosedFormOptions closed_form{options_.T_B_C, Sigma(), options_.gravity, options_.b_a_sigma};
    if (options_.camera1) closed_form.T_B_C1 = options_.camera1->T_B_C;
    return closed_form;
  }

  bool SolveLinearProblem() {
    start_ = SolveClosedForm(tracks_, imu_, LinearProblem());
    return IsCertain();
  }

  bool IsCertain() {
    result_.scale_sigma = start_.scale_sigma;
    result_.gravity_sigma = start_.gravity_sigma;
    if (!knows_scale_ && !(start_.scale_sigma <= options_.largest_scale_sigma)) {
      return Fail(InitializationFailure::kTooLittleExcitation,
                  "the scale is known to %.3g, %g is needed; change speed or direction", start_.scale_sigma,
                  options_.largest_scale_sigma);
    }
    return start_.gravity_sigma <= options_.largest_gravity_sigma ||
           Fail(InitializationFailure::kTooLittleExcitation,
                "gravity's direction is known to %.3g rad, %g is needed; change speed or direction",
                start_.gravity_sigma, options_.largest_gravity_sigma);
  }

  bool RefineAll() {
    std::optional<ClosedForm> second;
    if (!knows_scale_) second = SecondSolution(start_, imu_, options_.gravity);
    Fit fit = Refine(tracks_, imu_, options_, &start_);
    if (second) {
      const Fit other = Refine(tracks_, imu_, options_, &*second);
      if (other.cost < fit.cost) std::tie(fit, start_) = std::pair(other, *second);
    }
    result_.inliers = fit.inliers;
    if (!fit.has_points) {
      return Fail(InitializationFailure::kTooLittleExcitation,
                  "no point comes out in front of the camera and %g m away; change speed or direction",
                  kLeastPointDepth);
    }
    if (result_.inliers >= options_.least_inliers) return IsCertain();
    return Fail(InitializationFailure::kInconsistent, "%.2f of the observations fit, %g are needed", result_.inliers,
                options_.least_inliers);
  }

  double Sigma() const { return options_.pixel_sigma / options_.focal_length; }

  const DynamicInitializationOptions& options_;
  std::vector<Preintegration> imu_;
  std::vector<FeatureTrack> tracks_;
  bool knows_scale_ = false;  // by the second camera
  ClosedForm start_;
  DynamicInitialization result_;
};

}  // namespace

void DynamicInitializationOptions::Validate() const {
  CheckPositive("DynamicInitializationOptions::focal_length", focal_length);
  CheckPositive("DynamicInitializationOptions::pixel_sigma", pixel_sigma);
  CheckPositive("DynamicInitializationOptions::gravity", gravity);
  CheckPositive("DynamicInitializationOptions::b_a_sigma", b_a_sigma);
  CheckOption("DynamicInitializationOptions::least_tracks", least_tracks, 1);
  CheckOption("DynamicInitializationOptions::least_parallax", least_parallax, 0);
  CheckPositive("DynamicInitializationOptions::largest_scale_sigma", largest_scale_sigma);
  CheckPositive("DynamicInitializationOptions::largest_gravity_sigma", largest_gravity_sigma);
  CheckOption("DynamicInitializationOptions::least_inliers", least_inliers, 0, 1);
}

DynamicInitialization InitializeDynamically(const std::vector<InitializationImage>& frames,
                                            const DynamicInitializationOptions& options) {
  options.Validate();
  return DynamicInitializer(options).Run(frames);
}

}  // namespace ch5
