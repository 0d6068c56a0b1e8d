#include "ch5_backend/window/window.h"

#include <algorithm>

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

Vec2 Window::PointOf(const WindowObservation& seen) const {
  const double clock_offset = frames[static_cast<size_t>(IndexOf(seen.frame))].clock_offset;
  return MovingPoint{seen.x, seen.velocity, clock_offset}.At(time_offset->GetEstimate()[0]);
}

Vec2 Window::SecondPointOf(const WindowObservation& seen) const {
  const double clock_offset = frames[static_cast<size_t>(IndexOf(seen.frame))].clock_offset;
  return MovingPoint{seen.second->x, seen.second->velocity, clock_offset}.At(time_offset->GetEstimate()[0]);
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
      : weights_(weights),
        window_(*window),
        graph_(window->graph),
        calibrating_(!window->extrinsic->IsFixed() || !window->time_offset->IsFixed()),
        T_B_C_(window->T_B_C()),
        local_poses_(window->LocalPoses()),
        loss_(weights.cauchy > 0.0 ? std::make_shared<CauchyLoss>(weights.cauchy) : nullptr) {}

  void AddStates() {
    for (const Frame& frame : window_.frames) {
      graph_.AddVertex(frame.pose);
      if (frame.speed_bias) graph_.AddVertex(frame.speed_bias);
    }
    graph_.AddVertex(window_.extrinsic);
    if (window_.extrinsic1) graph_.AddVertex(window_.extrinsic1);
    graph_.AddVertex(window_.time_offset);
  }

  void AddImu() {
    for (size_t k = 1; k < window_.frames.size(); ++k) {
      const Frame &i = window_.frames[k - 1], &j = window_.frames[k];
      if (!i.speed_bias || !j.speed_bias || !j.imu || j.imu->SumDt() > weights_.max_imu_seconds) continue;
      Add(std::make_shared<EdgeImu>(i.pose, i.speed_bias, j.pose, j.speed_bias, j.imu,
                                    Vec3(0, 0, window_.calibration.gravity)));
    }
  }

  void AddLandmark(const WindowLandmark& landmark) {
    graph_.AddVertex(landmark.inverse_depth);
    if (weights_.noisy_hosts) return AddTrack(landmark);
    const double sqrt_information = window_.calibration.FocalLength() / weights_.pixel_sigma;
    const Mat22 W = sqrt_information * sqrt_information * Mat22::Identity();
    const WindowObservation& host = landmark.seen.front();
    const Frame& host_frame = FrameOf(host);
    for (size_t k = 1; k < landmark.seen.size(); ++k) {
      const WindowObservation& seen = landmark.seen[k];
      const Frame& frame = FrameOf(seen);
      std::shared_ptr<Edge> edge;
      if (calibrating_) {
        edge = std::make_shared<EdgeReprojectionCalibration>(
            landmark.inverse_depth, host_frame.pose, frame.pose, window_.extrinsic, window_.time_offset,
            MovingPoint{host.x, host.velocity, host_frame.clock_offset},
            MovingPoint{seen.x, seen.velocity, frame.clock_offset});
      } else {
        edge = std::make_shared<EdgeReprojection>(landmark.inverse_depth, host_frame.pose, frame.pose, host.x, seen.x,
                                                  T_B_C_);
      }
      edge->SetInformation(W);
      edge->SetLossFunction(loss_);
      Add(edge);
    }
    if (window_.extrinsic1) AddSecondViews(landmark);
  }

  void AddPriors() {
    if (window_.prior) {
      window_.prior->KeepJacobian(window_.observability_constraints == ObservabilityConstraints::kAllEdges);
      graph_.AddEdge(window_.prior);
    }
    if (window_.gauge_prior) graph_.AddEdge(window_.gauge_prior);
  }

 private:
  // What camera 1 sees of it, in the host's frame and in the others.
  void AddSecondViews(const WindowLandmark& landmark) {
    const double sqrt_information = window_.calibration.camera1->FocalLength() / weights_.pixel_sigma;
    const WindowObservation& host = landmark.seen.front();
    const Frame& host_frame = FrameOf(host);
    const MovingPoint host_point{host.x, host.velocity, host_frame.clock_offset};
    for (const WindowObservation& seen : landmark.seen) {
      if (!seen.second) continue;
      const Frame& frame = FrameOf(seen);
      const MovingPoint point{seen.second->x, seen.second->velocity, frame.clock_offset};
      std::shared_ptr<Edge> edge;
      if (&seen == &host) {
        edge = std::make_shared<EdgeStereoHost>(landmark.inverse_depth, window_.extrinsic, window_.extrinsic1,
                                                window_.time_offset, host_point, point);
      } else {
        edge = std::make_shared<EdgeStereo>(landmark.inverse_depth, host_frame.pose, frame.pose, window_.extrinsic,
                                            window_.extrinsic1, window_.time_offset, host_point, point);
      }
      edge->SetInformation(sqrt_information * sqrt_information * Mat22::Identity());
      edge->SetLossFunction(loss_);
      Add(edge);
    }
  }

  void AddTrack(const WindowLandmark& landmark) {
    std::vector<EdgeTrack::View> views;
    for (const WindowObservation& seen : landmark.seen) views.push_back({FrameOf(seen).pose, seen.x});
    Add(std::make_shared<EdgeTrack>(landmark.inverse_depth, views, T_B_C_,
                                    weights_.pixel_sigma / window_.calibration.FocalLength()));
  }

  void Add(std::shared_ptr<Edge> edge) {
    if (window_.prior && window_.observability_constraints == ObservabilityConstraints::kAllEdges) {
      edge = ConstrainObservability(std::move(edge), window_.prior->GetPrior(), local_poses_);
    }
    graph_.AddEdge(std::move(edge));
  }

  const Frame& FrameOf(const WindowObservation& observation) const {
    return window_.frames[static_cast<size_t>(window_.IndexOf(observation.frame))];
  }

  const WindowWeights& weights_;
  const Window& window_;
  Graph& graph_;
  bool calibrating_;
  Transform T_B_C_;
  std::vector<const Vertex*> local_poses_;
  std::shared_ptr<const LossFunction> loss_;
};

}  // namespace

void BuildGraph(const WindowWeights& weights, const std::function<bool(const Window&, const WindowLandmark&)>& uses,
                Window* window, const OwnEdges& own_edges) {
  window->graph = Graph();  // releases the vertices and edges of the old graph
  GraphBuilder builder(weights, window);
  builder.AddStates();
  if (own_edges) own_edges(*window, &window->graph);
  builder.AddImu();
  for (const auto& [id, landmark] : window->landmarks) {
    if (landmark.inverse_depth && uses(*window, landmark)) builder.AddLandmark(landmark);
  }
  builder.AddPriors();
}

}  // namespace ch5
