#include "ch5_backend/consistency/gauge_audit.h"

#include "ch5_backend/consistency/gauge_directions.h"
#include "ch5_backend/types/vertices.h"
#include "tests/consistency/free_windows.h"

namespace ch5 {
namespace {

// Differences with step 1e-5 leave about 1e-10; H's own rounding is far below.
constexpr double kNone = 1e-8;

TEST(GaugeAudit, AVisualInertialWindowKnowsNeitherPositionNorYaw) {
  const FreeWindow window;
  const auto leaks = AuditGauge(window.graph.Edges(), window.options);
  ASSERT_EQ(leaks.size(), 4u);
  for (const GaugeLeak& leak : leaks) {
    EXPECT_LT(leak.relative, kNone) << leak.direction;
    EXPECT_LT(std::abs(leak.gradient), 1e-3) << leak.direction;
  }
  // Gravity and the accelerometer tell the rest.
  GaugeOptions all = window.options;
  all.group = GaugeGroup::kMonocular;
  for (const char* direction : {"roll", "pitch", "scale"}) {
    EXPECT_GT(LeakAlong(direction, AuditGauge(window.graph.Edges(), all)).relative, 1e-3) << direction;
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
    EXPECT_NEAR(LeakAlong("x", leaks).information, 1e8, 1e3);
    EXPECT_NEAR(LeakAlong("y", leaks).information, 1e8, 1e3);
    EXPECT_LT(LeakAlong("z", leaks).relative, kNone);
    // Yaw about the mean position also moves frame 0, by its distance from there.
    Vec3 center = Vec3::Zero();
    for (const auto& pose : window.poses) center += pose->p() / 4.0;
    const double arm = (window.poses[0]->p() - center).head<2>().squaredNorm();
    EXPECT_NEAR(LeakAlong("yaw", leaks).information, yaw_information + 1e8 * arm, 1e-6 * (1e8 * arm + yaw_information));
  }
}

TEST(GaugeAudit, AFixedFrameHoldsTheGauge) {
  const FreeWindow window;
  window.poses[0]->SetFixed();
  for (const GaugeLeak& leak : AuditGauge(window.graph.Edges(), window.options)) {
    EXPECT_GT(leak.relative, 1e-6) << leak.direction;
  }
}

// By hand: turning about z moves a pose by e_z × (p − c), and its body by Rᵀe_z.
TEST(GaugeDirections, DirectionsAreThoseWorkedByHand) {
  auto a = std::make_shared<VertexPose>(ExpSO3({0.3, -0.2, 0.5}), Vec3(1, 2, 3));
  auto b = std::make_shared<VertexPose>(Qd::Identity(), Vec3(3, 4, 3));
  Vec9 v_ba_bg;
  v_ba_bg << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  auto speed_bias = std::make_shared<VertexSpeedBias>(v_ba_bg);
  auto depth = std::make_shared<VertexInverseDepth>(0.25);
  GaugeOptions options;
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

TEST(GaugeDirections, LocalPosesDoNotMove) {
  auto pose = std::make_shared<VertexPose>(Qd::Identity(), Vec3(1, 2, 3));
  auto extrinsic = std::make_shared<VertexPose>(Qd::Identity(), Vec3(5, 5, 5));
  GaugeOptions options;
  options.local_poses = {extrinsic.get()};
  const MatXX N = GaugeDirections({pose, extrinsic}, options);
  EXPECT_EQ(N.bottomRows(6).norm(), 0.0);
  EXPECT_LT(N.col(3).head<3>().norm(), 1e-9);  // the center is the mean of the other poses
}

}  // namespace
}  // namespace ch5
