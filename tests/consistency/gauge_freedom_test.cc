// What stage 4 of the homework asks for, by hand; its checks are in ch5_homework/judge/stage_4.cc.
#include "ch5_backend/consistency/gauge_freedom.h"

#include <gtest/gtest.h>

#include <cmath>

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
  EXPECT_EQ(TransformCovariance(I, I, Q, Q), (MatXX(2, 2) << 0, 0, 0, 2).finished());
  EXPECT_THROW(InverseOfVtU(U, Vec2(1, -1)), std::invalid_argument);
}

// Question 4 of the handout: what holds the yaw must meet it, at every attitude.
TEST(GaugeFreedom, YawIsHeldInTheWorldsAxesAndNotInTheBodysNorByAPoint) {
  for (const double roll : {0.0, 0.3, 0.5 * M_PI}) {
    const Qd q = ExpSO3(Vec3(0, 0, 0.4)) * ExpSO3(Vec3(roll, 0, 0));
    const auto pose = std::make_shared<VertexPose>(q, Vec3(1, 2, 3));
    const auto point = std::make_shared<VertexPointXYZ>(Vec3(4, 5, 6));
    const MatXX U = GaugeNullSpace({pose, point}, GaugeGroup::kVisualInertial);
    MatXX V = MatXX::Zero(9, 4);
    V.topLeftCorner<3, 3>().setIdentity();
    V.block<3, 1>(3, 3) = q.toRotationMatrix().transpose() * Vec3::UnitZ();
    EXPECT_NEAR((V.transpose() * U).determinant(), 1.0, 1e-12);
    V.block<3, 1>(3, 3) = Vec3::UnitZ();  // δθ's own third entry
    EXPECT_NEAR((V.transpose() * U).determinant(), std::cos(roll), 1e-12);
  }
}

TEST(GaugeFreedom, TwoPointsHoldYawUnlessTheirYIsTheSame) {
  for (const double y2 : {2.0, 7.0}) {
    const auto one = std::make_shared<VertexPointXYZ>(Vec3(1, 2, 3));
    const auto other = std::make_shared<VertexPointXYZ>(Vec3(9, y2, 8));
    const MatXX U = GaugeNullSpace({one, other}, GaugeGroup::kVisualInertial);
    const MatXX V = MatXX::Identity(6, 4);  // X₁ and x₂
    EXPECT_NEAR((V.transpose() * U).determinant(), 2.0 - y2, 1e-12);
    if (y2 == 2.0) {
      EXPECT_THROW(InverseOfVtU(U, V), std::invalid_argument);
    }
  }
}

// Question 6: with x2 told in units a tenth as long the shortest error of two numbers is another one.
TEST(GaugeFreedom, FreeDependsOnUnitsAndHeldDoesNot) {
  const MatXX U = Vec2(1, 10), I = MatXX::Identity(2, 2);
  const MatXX held = (MatXX(2, 2) << 0, 0, 0, 400).finished();  // σ = 2 in the old units
  const MatXX free = TransformCovariance(held, I, GaugeProjection(U, U), GaugeProjection(U, U));
  EXPECT_NEAR(std::sqrt(free(0, 0)), 1.98, 5e-3);
  EXPECT_NEAR(std::sqrt(free(1, 1)) / 10.0, 0.02, 5e-4);
  const MatXX Q = GaugeProjection(U, Vec2(1, 0));
  EXPECT_LT((TransformCovariance(free, I, Q, Q) - held).norm(), 1e-9);
}

}  // namespace
}  // namespace ch5
