#include "tests/consistency/first_estimates.h"
#include "ch5_backend/consistency/gauge_audit.h"

#include <gtest/gtest.h>

#include "tests/consistency/free_windows.h"

namespace ch5 {
namespace {

// Differences with step 1e-5 leave about 1e-10; H's own rounding is far below.
constexpr double kNone = 1e-8;

TEST(FirstEstimates, ResidualIsOfNowAndJacobianOfThen) {
  const FreeWindow window;
  const auto drop = window.Oldest();
  const EdgePrior prior(Marginalize(window.EdgesAt(drop), drop));
  const auto& edge = window.graph.Edges()[1];  // IMU between frames 1 and 2; the prior knows 1
  EdgeFirstEstimate first(edge, &prior.GetPrior());
  edge->Linearize();
  const MatXX then = edge->Jacobian(1);
  const VecX before = window.speed_biases[1]->Parameters(), delta = VecX::Constant(9, 0.05);
  window.speed_biases[1]->Plus(delta.data());
  const VecX moved = window.speed_biases[1]->Parameters();
  edge->Linearize();
  const VecX now = edge->Residual();
  EXPECT_GT((edge->Jacobian(1) - then).norm(), 1e-6);  // it does depend on the state
  first.Linearize();
  first.ComputeResidual();
  EXPECT_EQ(first.Jacobian(1), then);
  EXPECT_EQ(first.Residual(), now);
  EXPECT_EQ(window.speed_biases[1]->Parameters(), moved);
}

// What is linearized at the first estimates of the states in the prior.
enum class FirstEstimates { kNone, kMarginalizedEdges, kAllEdges };

// A window that slides: between two marginalizations every state moves a little, as a solve moves it.
struct SlidingWindow {
  FreeWindow window{8};
  FirstEstimates mode;
  std::shared_ptr<EdgePrior> prior;
  Random random{17};

  explicit SlidingWindow(FirstEstimates first_estimates) : mode(first_estimates) {}

  const Prior* Points(FirstEstimates at_least) const {
    return prior && mode >= at_least ? &prior->GetPrior() : nullptr;
  }
  void Move() {
    for (const auto& v : window.graph.Vertices()) {
      VecX delta(v->LocalDimension());
      for (int k = 0; k < delta.size(); ++k) delta[k] = 0.02 * random.Normal();
      if (v->GetRole() == Role::kPose && v.get() != window.extrinsic.get()) v->Plus(delta.data());
    }
  }
  void Slide(size_t frame) {
    std::vector<std::shared_ptr<Vertex>> drop{window.poses[frame], window.speed_biases[frame]};
    for (size_t l = frame; l < window.landmarks.size(); l += 2) {
      if (frame < 2) drop.push_back(window.landmarks[l]);
    }
    const auto edges = window.EdgesAt(drop);
    Prior next;
    {
      const ScopedLinearizationPoint at_linearization(Points(FirstEstimates::kMarginalizedEdges));
      next = Marginalize(edges, drop);
    }
    for (const auto& edge : edges) window.graph.RemoveEdge(edge);
    for (const auto& v : drop) window.graph.RemoveVertex(v);
    prior = std::make_shared<EdgePrior>(std::move(next));
    window.graph.AddEdge(prior);
  }
  // H of a solve: the graph's edges and the prior, linearized as the mode says.
  GaugeLeak Yaw() {
    std::vector<std::shared_ptr<Edge>> edges = window.graph.Edges();
    const Prior* points = Points(FirstEstimates::kAllEdges);
    for (auto& edge : edges) {
      if (points) edge = std::make_shared<EdgeFirstEstimate>(edge, points);
    }
    // The Jacobians are taken where the prior's were, and so are the directions.
    const ScopedLinearizationPoint at_first_estimates(points);
    return LeakAlong("yaw", AuditGauge(edges, window.options));
  }
};

// VN9: a prior leaks nothing where it was made; once the states have moved, it and the edges that moved on do not
// agree what yaw is, and yaw becomes known. First estimates everywhere keep it unknown for window.
TEST(FirstEstimates, OnlyOnAllEdgesTheyKeepYawUnobservable) {
  for (const FirstEstimates mode :
       {FirstEstimates::kNone, FirstEstimates::kMarginalizedEdges, FirstEstimates::kAllEdges}) {
    SlidingWindow window(mode);
    for (size_t frame = 0; frame < 4; ++frame) {
      window.Slide(frame);
      if (frame == 0) {
        EXPECT_LT(window.Yaw().relative, kNone);
      }
      window.Move();
      const GaugeLeak yaw = window.Yaw();
      if (mode == FirstEstimates::kAllEdges) {
        EXPECT_LT(yaw.relative, kNone) << "slide " << frame;
      } else {
        EXPECT_GT(yaw.relative, 1e-5) << "slide " << frame;
        EXPECT_GT(yaw.information, 0.1) << "slide " << frame;  // out of nothing
      }
    }
  }
}

// A prior linearized at its first estimates has no information on yaw there.
TEST(FirstEstimates, OnMarginalizedEdgesTheyKeepThePriorFreeOfYaw) {
  for (const bool clean : {true, false}) {
    SlidingWindow window(clean ? FirstEstimates::kMarginalizedEdges : FirstEstimates::kNone);
    for (size_t frame = 0; frame < 3; ++frame) {
      window.Slide(frame);
      window.Move();
    }
    const GaugeLeak yaw = LeakAlong("yaw", AuditPrior(window.prior->GetPrior(), window.window.options));
    EXPECT_EQ(yaw.relative < kNone, clean) << yaw.relative;
  }
}

}  // namespace
}  // namespace ch5
