#include "ch5_backend/consistency/gauge_audit.h"

#include "ch5_backend/consistency/first_estimates.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "tests/marginalize/scenes.h"

namespace ch5 {
namespace {

// Differences of step 1e-5 leave about 1e-10; H's own rounding is far below.
constexpr double kNone = 1e-8;

GaugeLeak Leak(const std::vector<GaugeLeak>& leaks, const std::string& direction) {
  for (const GaugeLeak& leak : leaks) {
    if (leak.direction == direction) return leak;
  }
  ADD_FAILURE() << "no direction " << direction;
  return {};
}

// A window whose gauge nothing holds.
struct FreeWindow : SmallWindow {
  explicit FreeWindow(int frames = 4) : SmallWindow(1, frames) {
    graph.RemoveEdge(graph.Edges().front());  // the prior on frame 0
    options.bystanders = {extrinsic.get()};
  }
  GaugeAuditOptions options;
};

// By hand: turning about z moves a pose by e_z × (p − c), and its body by Rᵀe_z.
TEST(GaugeAudit, DirectionsAreThoseWorkedByHand) {
  auto a = std::make_shared<VertexPose>(ExpSO3({0.3, -0.2, 0.5}), Vec3(1, 2, 3));
  auto b = std::make_shared<VertexPose>(Qd::Identity(), Vec3(3, 4, 3));
  Vec9 v_ba_bg;
  v_ba_bg << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  auto speed_bias = std::make_shared<VertexSpeedBias>(v_ba_bg);
  auto depth = std::make_shared<VertexInverseDepth>(0.25);
  GaugeAuditOptions options;
  options.group = GaugeGroup::kMonocular;
  const MatXX N = GaugeDirections({a, b, speed_bias, depth}, options);
  ASSERT_EQ(N.rows(), 6 + 6 + 9 + 1);
  ASSERT_EQ(N.cols(), 7);
  EXPECT_LT((N.col(3).segment<3>(0) - Vec3(1, -1, 0)).norm(), 1e-9);  // c = (2, 3, 3)
  EXPECT_LT((N.col(3).segment<3>(3) - a->R().transpose() * Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_LT((N.col(3).segment<3>(12) - Vec3(-2, 1, 0)).norm(), 1e-9);
  EXPECT_EQ(N.col(3).segment<6>(15).norm(), 0.0);
  EXPECT_LT((N.col(0).segment<3>(6) - Vec3::UnitX()).norm(), 1e-9);
  EXPECT_NEAR(N(21, 6), -0.25, 1e-9);                                  // d(λ/s)/d ln s
  EXPECT_LT((N.col(6).segment<3>(0) - Vec3(-1, -1, 0)).norm(), 1e-9);  // p − c
}

TEST(GaugeAudit, AVisualInertialWindowKnowsNeitherPositionNorYaw) {
  const FreeWindow window;
  const auto leaks = AuditGauge(window.graph.Edges(), window.options);
  ASSERT_EQ(leaks.size(), 4u);
  for (const GaugeLeak& leak : leaks) {
    EXPECT_LT(leak.relative, kNone) << leak.direction;
    EXPECT_LT(std::abs(leak.gradient), 1e-3) << leak.direction;
  }
  // Gravity and the accelerometer tell the rest.
  GaugeAuditOptions all = window.options;
  all.group = GaugeGroup::kMonocular;
  for (const char* direction : {"roll", "pitch", "scale"}) {
    EXPECT_GT(Leak(AuditGauge(window.graph.Edges(), all), direction).relative, 1e-3) << direction;
  }
}

// Without IMU, and the extrinsic at the body's origin, seven directions are free.
TEST(GaugeAudit, ACameraAloneDoesNotKnowScaleEither) {
  FreeWindow window;
  window.extrinsic->SetPose(window.extrinsic->q(), Vec3::Zero());
  window.extrinsic->SetFixed();
  std::vector<std::shared_ptr<Edge>> vision;
  for (const auto& edge : window.graph.Edges()) {
    if (edge->TypeInfo() != "EdgeImu") vision.push_back(edge);
  }
  window.options.group = GaugeGroup::kMonocular;
  const auto leaks = AuditGauge(vision, window.options);
  ASSERT_EQ(leaks.size(), 7u);
  for (const GaugeLeak& leak : leaks) EXPECT_LT(leak.relative, kNone) << leak.direction;
}

// OK11: a prior on position and yaw of the first frame shows in exactly its directions, with its information.
TEST(GaugeAudit, AGaugePriorShowsInItsDirections) {
  const FreeWindow window;
  for (const auto& pose : window.poses) pose->SetPose(pose->q(), pose->p() - Vec3(0.45, 0, 0));
  window.poses[0]->SetPose(Qd::Identity(), window.poses[0]->p());
  for (const double yaw_information : {0.0, 1e8}) {
    auto prior = std::make_shared<EdgeSE3Prior>(window.poses[0], window.poses[0]->q(), window.poses[0]->p());
    Vec6 information;
    information << 0, 0, yaw_information, 1e8, 1e8, 0;  // rows [rotation, position]: x, y, and yaw or not
    prior->SetInformation(MatXX(information.asDiagonal()));
    auto edges = window.graph.Edges();
    edges.push_back(prior);
    const auto leaks = AuditGauge(edges, window.options);
    EXPECT_NEAR(Leak(leaks, "x").information, 1e8, 1e3);
    EXPECT_NEAR(Leak(leaks, "y").information, 1e8, 1e3);
    EXPECT_LT(Leak(leaks, "z").relative, kNone);
    // Yaw about the mean position also moves frame 0, by its distance from there.
    Vec3 center = Vec3::Zero();
    for (const auto& pose : window.poses) center += pose->p() / 4.0;
    const double arm = (window.poses[0]->p() - center).head<2>().squaredNorm();
    EXPECT_NEAR(Leak(leaks, "yaw").information, yaw_information + 1e8 * arm, 1e-6 * (1e8 * arm + yaw_information));
  }
}

TEST(GaugeAudit, AFixedFrameHoldsTheGauge) {
  const FreeWindow window;
  window.poses[0]->SetFixed();
  for (const GaugeLeak& leak : AuditGauge(window.graph.Edges(), window.options)) {
    EXPECT_GT(leak.relative, 1e-6) << leak.direction;
  }
}

// ---- the life of a prior ---------------------------------------------------------------------------------------

// A window that slides: between two marginalisations every state moves a little, as a solve moves it.
struct Life {
  FreeWindow window{8};
  FirstEstimates mode;
  std::shared_ptr<EdgePrior> prior;
  Random random{17};

  explicit Life(FirstEstimates first_estimates) : mode(first_estimates) {}

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
      const MovedVertices at_linearisation(Points(FirstEstimates::kPriorOnly));
      next = Marginalize(edges, drop);
    }
    for (const auto& edge : edges) window.graph.RemoveEdge(edge);
    for (const auto& v : drop) window.graph.RemoveVertex(v);
    prior = std::make_shared<EdgePrior>(std::move(next));
    window.graph.AddEdge(prior);
  }
  // H of a solve: of the live edges and the prior, as the mode linearises them.
  GaugeLeak Yaw() {
    std::vector<std::shared_ptr<Edge>> edges = window.graph.Edges();
    window.options.first_estimates = Points(FirstEstimates::kFull);
    if (window.options.first_estimates) {
      for (auto& edge : edges) edge = std::make_shared<EdgeFirstEstimate>(edge, window.options.first_estimates);
    }
    return Leak(AuditGauge(edges, window.options), "yaw");
  }
};

// VN9: a prior leaks nothing where it was made; once the states have moved, it and the edges that moved on do not
// agree what yaw is, and yaw becomes known. First estimates everywhere keep it unknown for life.
TEST(GaugeAudit, OnlyFullFirstEstimatesKeepYawUnknown) {
  for (const FirstEstimates mode : {FirstEstimates::kNone, FirstEstimates::kPriorOnly, FirstEstimates::kFull}) {
    Life life(mode);
    for (size_t frame = 0; frame < 4; ++frame) {
      life.Slide(frame);
      if (frame == 0) {
        EXPECT_LT(life.Yaw().relative, kNone);
      }
      life.Move();
      const GaugeLeak yaw = life.Yaw();
      if (mode == FirstEstimates::kFull) {
        EXPECT_LT(yaw.relative, kNone) << "slide " << frame;
      } else {
        EXPECT_GT(yaw.relative, 1e-5) << "slide " << frame;
        EXPECT_GT(yaw.information, 0.1) << "slide " << frame;  // out of nothing
      }
    }
  }
}

// What was linearised at its first estimates is a prior without yaw, when the audit looks there.
TEST(GaugeAudit, PriorOnlyKeepsThePriorItselfClean) {
  for (const bool clean : {true, false}) {
    Life life(clean ? FirstEstimates::kPriorOnly : FirstEstimates::kNone);
    for (size_t frame = 0; frame < 3; ++frame) {
      life.Slide(frame);
      life.Move();
    }
    const MovedVertices at_linearisation(&life.prior->GetPrior());
    const GaugeLeak yaw = Leak(AuditGauge({life.prior}, life.window.options), "yaw");
    EXPECT_EQ(yaw.relative < kNone, clean) << yaw.relative;
  }
}

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

}  // namespace
}  // namespace ch5
