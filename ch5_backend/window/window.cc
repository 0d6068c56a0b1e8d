#include "ch5_backend/window/window.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/types/visual/edge_reprojection_calibration.h"
#include "ch5_backend/types/visual/edge_stereo.h"
#include "ch5_backend/types/visual/edge_track.h"

namespace ch5 {

void WindowWeights::Validate() const {
  CheckPositive("WindowWeights::pixel_sigma", pixel_sigma);
  CheckOption("WindowWeights::cauchy", cauchy, 0);
  CheckPositive("WindowWeights::max_imu_seconds", max_imu_seconds);
}

int Window::IndexOf(int id) const {
  const auto it = std::lower_bound(frames.begin(), frames.end(), id,
                                   [](const Frame& frame, int wanted) { return frame.id < wanted; });
  return it != frames.end() && it->id == id ? static_cast<int>(it - frames.begin()) : -1;
}

const WindowObservation* WindowLandmark::In(int frame) const {
  const auto it = std::lower_bound(seen.begin(), seen.end(), frame,
                                   [](const WindowObservation& one, int wanted) { return one.frame < wanted; });
  return it != seen.end() && it->frame == frame ? &*it : nullptr;
}

StampedState Window::StateOf(const Frame& frame) const {
  StampedState state;
  state.t = frame.t;
  state.T_W_B = {frame.pose->q(), frame.pose->p()};
  if (frame.speed_bias) {
    state.v_W = frame.speed_bias->v();
    state.b_a = frame.speed_bias->b_a();
    state.b_g = frame.speed_bias->b_g();
  }
  return state;
}

void Window::SetState(const StampedState& state, const Frame& frame) {
  frame.pose->SetPose(state.T_W_B.q, state.T_W_B.p);
  Vec9 v_ba_bg;
  v_ba_bg << state.v_W, state.b_a, state.b_g;
  frame.speed_bias->SetEstimate(v_ba_bg);
}

Vec2 Window::PointAt(int frame, const Vec2& x, const Vec2& velocity) const {
  const double clock_offset = frames[static_cast<size_t>(IndexOf(frame))].clock_offset;
  return MovingPoint{x, velocity, clock_offset}.At(time_offset->GetEstimate()[0]);
}

bool ObservationModel::Fits(const ObservationModel& other) const {
  return calibrating == other.calibrating && T_B_C.q.coeffs() == other.T_B_C.q.coeffs() && T_B_C.p == other.T_B_C.p &&
         information == other.information && information1 == other.information1 && cauchy == other.cauchy;
}

std::vector<const Vertex*> Window::LocalPoses() const {
  if (!extrinsic1) return {extrinsic.get()};
  return {extrinsic.get(), extrinsic1.get()};
}

namespace {

// The parts of BuildGraph.
class GraphBuilder {
 public:
  GraphBuilder(const WindowWeights& weights, Window* window)
      : weights_(weights), window_(*window), graph_(window->graph), model_(window->model) {
    if (window->prior && window->observability_constraints == ObservabilityConstraints::kAllEdges) {
      constrained_local_poses_ = window->LocalPoses();
    }
  }

  void AddStates() {
    for (const Frame& frame : window_.frames) {
      graph_.AddVertex(frame.pose);
      if (frame.speed_bias) graph_.AddVertex(frame.speed_bias);
      if (frame.speed_bias && frame.is_at_rest) AddRest(frame.speed_bias);
    }
    graph_.AddVertex(window_.extrinsic);
    if (window_.extrinsic1) graph_.AddVertex(window_.extrinsic1);
    graph_.AddVertex(window_.time_offset);
  }

  void AddImu() {
    for (size_t k = 1; k < window_.frames.size(); ++k) {
      const Frame& i = window_.frames[k - 1];
      Frame& j = window_.frames[k];
      if (!i.speed_bias || !j.speed_bias || !j.imu || j.prior_has_imu) continue;
      if (j.imu->SumDt() > weights_.max_imu_seconds) continue;
      if (!j.imu_edge || !j.imu_edge->IsMadeOf(*j.imu) || j.imu_edge->Vertices().front() != i.pose) {
        j.imu_edge = MakeShared<EdgeImu>(i.pose, i.speed_bias, j.pose, j.speed_bias, j.imu,
                                         Vec3(0, 0, window_.calibration.gravity));
      }
      Add(j.imu_edge);
    }
  }

  void AddLandmark(WindowLandmark* landmark) {
    graph_.AddVertex(landmark->inverse_depth);
    if (weights_.noisy_hosts) return AddTrack(*landmark);
    const WindowObservation& host = landmark->seen.front();
    const Frame& host_frame = FrameOf(host);
    const auto& depth = landmark->inverse_depth;
    const auto& pose_i = host_frame.pose;
    const MovingPoint host_point = PointAt(host, host_frame);
    for (size_t k = 1; k < landmark->seen.size(); ++k) {
      WindowObservation& seen = landmark->seen[k];
      const Frame& frame = FrameOf(seen);
      if (!model_.calibrating) {
        AddKept(model_.information, &seen.edge, depth,
                [&] { return MakeShared<EdgeReprojection>(depth, pose_i, frame.pose, host.x, seen.x, model_.T_B_C); });
      } else {
        AddMoving<EdgeReprojectionCalibration>(model_.information, host_point, PointAt(seen, frame), &seen.edge, depth,
                                               pose_i, frame.pose, window_.extrinsic);
      }
    }
    if (window_.extrinsic1) AddSecondViews(host_point, host_frame, landmark);
  }

  void AddPriors() {
    if (window_.prior) {
      window_.prior->KeepJacobian(window_.observability_constraints == ObservabilityConstraints::kAllEdges);
      graph_.AddEdge(window_.prior);
    }
    if (window_.gauge_prior) graph_.AddEdge(window_.gauge_prior);
  }

 private:
  // v = 0.
  void AddRest(const std::shared_ptr<VertexSpeedBias>& speed_bias) {
    Prior rest{{speed_bias}, {VecX::Zero(9)}, MatXX::Identity(3, 9) / kRestSpeedSigma, VecX::Zero(3)};
    graph_.AddEdge(std::make_shared<EdgePrior>(std::move(rest)));
  }

  // What camera 1 sees of it, in the host's frame and in the others.
  void AddSecondViews(const MovingPoint& host_point, const Frame& host_frame, WindowLandmark* landmark) {
    const auto& depth = landmark->inverse_depth;
    for (WindowObservation& seen : landmark->seen) {
      if (!seen.second) continue;
      const Frame& frame = FrameOf(seen);
      const MovingPoint point = PointAt(*seen.second, frame);
      if (&frame == &host_frame) {
        AddMoving<EdgeStereoHost>(model_.information1, host_point, point, &seen.second->edge, depth, window_.extrinsic,
                                  window_.extrinsic1);
      } else {
        AddMoving<EdgeStereo>(model_.information1, host_point, point, &seen.second->edge, depth, host_frame.pose,
                              frame.pose, window_.extrinsic, window_.extrinsic1);
      }
    }
  }

  // An observation's edge: that of the graph before if its landmark has the same vertex still, and with it the same host,
  // else a new one.
  template <typename Make>
  void AddKept(double information, std::shared_ptr<Edge>* kept, const std::shared_ptr<VertexInverseDepth>& depth,
               const Make& make) {
    if (!*kept || (*kept)->Vertices().front() != depth) {
      *kept = make();
      (*kept)->SetIsotropicInformation(information);
      (*kept)->SetLossFunction(model_.loss);
    }
    Add(*kept);
  }

  // What a kept edge measures is the same but for velocities.
  template <typename EdgeType, typename... Poses>
  void AddMoving(double information, const MovingPoint& host, const MovingPoint& target, std::shared_ptr<Edge>* kept,
                 const std::shared_ptr<VertexInverseDepth>& depth, const Poses&... poses) {
    AddKept(information, kept, depth,
            [&] { return MakeShared<EdgeType>(depth, poses..., window_.time_offset, host, target); });
    static_cast<EdgeType*>(kept->get())->SetPoints(host, target);
  }

  // For an observation, or for one of camera 1.
  template <typename Seen>
  static MovingPoint PointAt(const Seen& seen, const Frame& frame) {
    return {seen.x, seen.velocity, frame.clock_offset};
  }

  void AddTrack(const WindowLandmark& landmark) {
    std::vector<EdgeTrack::View> views;
    for (const WindowObservation& seen : landmark.seen) views.push_back({FrameOf(seen).pose, seen.x});
    Add(std::make_shared<EdgeTrack>(landmark.inverse_depth, views, window_.T_B_C(),
                                    weights_.pixel_sigma / window_.calibration.FocalLength()));
  }

  void Add(std::shared_ptr<Edge> edge) {
    if (constrained_local_poses_) {
      edge = ConstrainObservability(std::move(edge), window_.prior->GetPrior(), *constrained_local_poses_);
    }
    graph_.AddEdge(std::move(edge));
  }

  const Frame& FrameOf(const WindowObservation& observation) const {
    return window_.frames[static_cast<size_t>(window_.IndexOf(observation.frame))];
  }

  const WindowWeights& weights_;
  Window& window_;
  Graph& graph_;
  const ObservationModel& model_;
  std::optional<std::vector<const Vertex*>> constrained_local_poses_;  // where each edge is constrained
};

// Forgets the edges of the graph before if they were made for another model.
void UpdateModel(const WindowWeights& weights, Window* window) {
  const auto information = [&](const Camera& camera) {
    return std::pow(camera.FocalLength() / weights.pixel_sigma, 2);
  };
  ObservationModel model;
  model.calibrating = !window->extrinsic->IsFixed() || !window->time_offset->IsFixed();
  if (!model.calibrating) model.T_B_C = window->T_B_C();
  model.information = information(window->calibration);
  if (window->extrinsic1) model.information1 = information(*window->calibration.camera1);
  model.cauchy = weights.cauchy;
  if (model.Fits(window->model)) return;
  if (model.cauchy > 0.0) model.loss = std::make_shared<CauchyLoss>(model.cauchy);
  window->model = std::move(model);
  for (auto& [id, landmark] : window->landmarks) {
    for (WindowObservation& seen : landmark.seen) {
      seen.edge = nullptr;
      if (seen.second) seen.second->edge = nullptr;
    }
  }
}

}  // namespace

void BuildGraph(const WindowWeights& weights, const std::function<bool(const Window&, const WindowLandmark&)>& uses,
                Window* window, const OwnEdges& own_edges) {
  window->graph.Clear();  // releases the vertices and edges of the old graph
  UpdateModel(weights, window);
  GraphBuilder builder(weights, window);
  builder.AddStates();
  const auto& edges = window->graph.Edges();
  const size_t others = edges.size();
  if (own_edges) own_edges(*window, &window->graph);
  window->own_edges.assign(edges.begin() + static_cast<std::ptrdiff_t>(std::min(others, edges.size())), edges.end());
  builder.AddImu();
  for (auto& [id, landmark] : window->landmarks) {
    if (landmark.inverse_depth && uses(*window, landmark)) builder.AddLandmark(&landmark);
  }
  builder.AddPriors();
}

}  // namespace ch5
