#include "ch5_backend/consistency/gauge_directions.h"

#include <gtest/gtest.h>

#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

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

TEST(GaugeDirections, NamesAreThoseOfTheColumns) {
  EXPECT_EQ(GaugeDirectionNames(GaugeGroup::kVisualInertial), (std::vector<std::string>{"x", "y", "z", "yaw"}));
  EXPECT_EQ(GaugeDirectionNames(GaugeGroup::kMonocular).size(), 7u);
}

}  // namespace
}  // namespace ch5
