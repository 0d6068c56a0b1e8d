#include "ch5_backend/experiments/studies/window_graph.h"

#include <stdexcept>

#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5 {
namespace {

// Without Triggs' second-order term, as Ceres has these two: Cauchy's leaves no curvature along r where s = 1, and
// the Gauss-Newton step of a depth that two images see is then far too long.
std::shared_ptr<const LossFunction> MakeLoss(const WindowDump& dump) {
  constexpr auto kIrls = LossCorrection::kIrls;
  switch (dump.loss) {
    case WindowDump::Loss::kHuber: return std::make_shared<HuberLoss>(dump.loss_parameter, kIrls);
    case WindowDump::Loss::kCauchy: return std::make_shared<CauchyLoss>(dump.loss_parameter, kIrls);
    case WindowDump::Loss::kNone: break;
  }
  return nullptr;
}

void AddStates(const WindowDump& dump, WindowGraph* window) {
  for (const StampedState& state : dump.frames) {
    window->poses.push_back(std::make_shared<VertexPose>(state.T_W_B.q, state.T_W_B.p));
    window->graph.AddVertex(window->poses.back());
    if (dump.imu.empty()) continue;
    Vec9 v_ba_bg;
    v_ba_bg << state.v_W, state.b_a, state.b_g;
    window->speed_biases.push_back(std::make_shared<VertexSpeedBias>(v_ba_bg));
    window->graph.AddVertex(window->speed_biases.back());
  }
  for (const int frame : dump.fixed_frames) window->poses[static_cast<size_t>(frame)]->SetFixed();
  window->extrinsic = std::make_shared<VertexPose>(dump.T_B_C.q, dump.T_B_C.p);
  window->extrinsic->SetFixed(dump.extrinsic_fixed);
  window->graph.AddVertex(window->extrinsic);
}

void AddImu(const WindowDump& dump, WindowGraph* window) {
  for (const WindowDump::ImuInterval& interval : dump.imu) {
    const auto imu = std::make_shared<Preintegration>(interval.samples, interval.b_a, interval.b_g, dump.noise);
    const auto i = static_cast<size_t>(interval.i), j = static_cast<size_t>(interval.j);
    window->graph.AddEdge(std::make_shared<EdgeImu>(window->poses[i], window->speed_biases[i], window->poses[j],
                                                    window->speed_biases[j], imu, dump.reaction));
  }
}

void AddLandmarks(const WindowDump& dump, WindowGraph* window) {
  const auto loss = MakeLoss(dump);
  const Mat22 W = dump.sqrt_information * dump.sqrt_information * Mat22::Identity();
  for (const WindowDump::Landmark& landmark : dump.landmarks) {
    auto inverse_depth = std::make_shared<VertexInverseDepth>(landmark.inverse_depth);
    window->landmarks.push_back(inverse_depth);
    window->graph.AddVertex(inverse_depth);
    const auto& host = window->poses[static_cast<size_t>(landmark.host)];
    for (const WindowDump::Observation& seen : landmark.observations) {
      const auto& target = window->poses[static_cast<size_t>(seen.frame)];
      std::shared_ptr<Edge> edge;
      if (dump.extrinsic_fixed) {
        edge = std::make_shared<EdgeReprojection>(inverse_depth, host, target, landmark.x_host, seen.x, dump.T_B_C);
      } else {
        edge = std::make_shared<EdgeReprojectionExtrinsic>(inverse_depth, host, target, window->extrinsic,
                                                           landmark.x_host, seen.x);
      }
      edge->SetInformation(W);
      edge->SetLossFunction(loss);
      window->graph.AddEdge(edge);
    }
  }
}

void AddPrior(const WindowDump& dump, WindowGraph* window) {
  if (dump.prior_r.size() == 0) return;
  Prior prior{{}, {}, dump.prior_J, dump.prior_r};
  for (const WindowDump::PriorBlock& block : dump.prior_blocks) {
    const auto frame = static_cast<size_t>(block.frame);
    switch (block.kind) {
      case WindowDump::BlockKind::kPose: prior.vertices.push_back(window->poses[frame]); break;
      case WindowDump::BlockKind::kSpeedBias:
        if (frame >= window->speed_biases.size()) {
          throw std::invalid_argument("the prior holds speed and biases of frame " + std::to_string(frame) +
                                      ", but the window has no IMU");
        }
        prior.vertices.push_back(window->speed_biases[frame]);
        break;
      case WindowDump::BlockKind::kExtrinsic: prior.vertices.push_back(window->extrinsic); break;
    }
    prior.x0.push_back(block.x0);
  }
  window->graph.AddEdge(std::make_shared<EdgePrior>(prior));
}

}  // namespace

WindowGraph BuildWindowGraph(const WindowDump& dump) {
  WindowGraph window;
  AddStates(dump, &window);
  AddImu(dump, &window);
  AddLandmarks(dump, &window);
  AddPrior(dump, &window);
  return window;
}

DropSet OldestFrameOf(const WindowDump& dump, const WindowGraph& window) {
  DropSet oldest{{}, {window.poses.front()}};
  if (!window.speed_biases.empty()) oldest.vertices.push_back(window.speed_biases.front());
  for (size_t l = 0; l < dump.landmarks.size(); ++l) {
    if (dump.landmarks[l].host == 0) oldest.vertices.push_back(window.landmarks[l]);
  }
  oldest.edges = EdgesAt(window.graph, oldest.vertices);
  return oldest;
}

}  // namespace ch5
