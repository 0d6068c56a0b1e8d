// What stage 4 of the homework asks for, by hand; its checks are in ../homework/stage_4.cc.
#include "ch5_backend/consistency/gauge_freedom.h"

#include <gtest/gtest.h>

#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

TEST(GaugeFreedom, AQuarterTurnAndAShiftByHand) {
  const auto pose = std::make_shared<VertexPose>(Qd::Identity(), Vec3(1, 0, 0));
  const auto point = std::make_shared<VertexPointXYZ>(Vec3(0, 3, 0));
  const Vertices vertices{pose, point};
  EXPECT_EQ(TotalLocalDimension(vertices), 9);
  EXPECT_EQ(NumGaugeDirections(GaugeGroup::kMonocular), 7);
  const MatXX U = GaugeNullSpace(vertices, GaugeGroup::kVisualInertial);
  MatXX expected = MatXX::Zero(9, 4);
  expected.topLeftCorner<3, 3>().setIdentity();
  expected.bottomLeftCorner<3, 3>().setIdentity();
  expected(1, 3) = 1.0;   // e_z × (1, 0, 0)
  expected(5, 3) = 1.0;   // δθ = e_z
  expected(6, 3) = -3.0;  // e_z × (0, 3, 0)
  EXPECT_LT((U - expected).norm(), 1e-15);

  MatXX turn = MatXX::Identity(9, 9);
  for (const int row : {0, 6}) turn.block<2, 2>(row, row) << 0, -1, 1, 0;
  EXPECT_LT((GaugeMotionJacobian(vertices, 0.5 * M_PI) - turn).norm(), 1e-15);
}

// Two numbers that both move with the gauge, the first of which is held.
TEST(GaugeFreedom, HoldingOneOfTwoNumbersByHand) {
  const MatXX U = Vec2(1, 1), V = Vec2(1, 0), I = MatXX::Identity(2, 2);
  EXPECT_DOUBLE_EQ(InverseOfVtU(U, V)(0, 0), 1.0);
  const MatXX Q = GaugeProjection(U, V);
  EXPECT_EQ(Q, (MatXX(2, 2) << 0, 0, -1, 1).finished());
  EXPECT_EQ(TransformCovariance(I, Q, I), (MatXX(2, 2) << 0, 0, 0, 2).finished());
  EXPECT_THROW(InverseOfVtU(U, Vec2(1, -1)), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
