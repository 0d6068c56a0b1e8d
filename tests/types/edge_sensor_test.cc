#include "ch5_backend/types/pose_graph/edge_sensor.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/pose_graph/edge_between.h"
#include "tests/derivatives.h"

namespace ch5 {
namespace {

class SensorOnAPose : public testing::Test {
 protected:
  std::shared_ptr<VertexSE2> InPlane() {
    return std::make_shared<VertexSE2>(Vec2(random_.Normal(), random_.Normal()), 2.0 * random_.Normal());
  }
  std::shared_ptr<VertexPose> InSpace() {
    return std::make_shared<VertexPose>(ExpSO3(NormalVector(&random_, 1.0)), NormalVector(&random_, 2.0));
  }
  Random random_{77};
};

TEST_F(SensorOnAPose, JacobiansAgreeWithCentralDifferences) {
  for (int k = 0; k < 20; ++k) {
    const auto i = InPlane(), j = InPlane(), offset = InPlane();
    const auto l = std::make_shared<VertexPointXY>(Vec2(3.0 + k, random_.Normal()));
    const auto I = InSpace(), J = InSpace(), in_I = InSpace(), in_J = InSpace();
    const auto L = std::make_shared<VertexPointXYZ>(NormalVector(&random_, 5.0));
    EdgePointXY point(i, l, Vec2(1, 2), offset->GetEstimate());
    EdgePointCalibration calibration(i, l, offset, Vec2(1, 2));
    EdgeBearing bearing(i, l, random_.Normal());
    EdgeOffset<VertexSE2> planar(i, j, InPlane()->GetEstimate(), offset->GetEstimate(), InPlane()->GetEstimate());
    EdgePointXYZ point_in_space(I, L, Vec3(1, 2, 3), in_I->GetEstimate());
    EdgeOffset<VertexPose> spatial(I, J, InSpace()->GetEstimate(), in_I->GetEstimate(), in_J->GetEstimate());
    EdgePositions<2, VertexPointXY, VertexSE2> prior_in_plane(l, i, Vec2(1, 2));
    EdgePositions<3, VertexPointXYZ, VertexPose> prior_in_space(L, I, Vec3(1, 2, 3));
    for (Edge* edge : std::initializer_list<Edge*>{&point, &calibration, &bearing, &planar, &point_in_space, &spatial,
                                                   &prior_in_plane, &prior_in_space}) {
      ExpectJacobiansAreDerivatives(edge, edge->TypeInfo());
    }
  }
}

// The robot stands at (1, 2) and looks along y; its sensor is 1 m ahead and looks to the left, along −x. A landmark at
// (−2, 7) is 5 m ahead of the robot and 3 m to its left, so 3 m ahead of the sensor and 4 m to its right.
TEST_F(SensorOnAPose, ResidualsWorkedByHand) {
  const auto robot = std::make_shared<VertexSE2>(Vec2(1, 2), M_PI / 2);
  const auto l = std::make_shared<VertexPointXY>(Vec2(-2, 7));
  const Vec3 to_the_left(1, 0, M_PI / 2);
  EdgePointXY point(robot, l, Vec2(3, -4), to_the_left);
  EdgePointXY without(robot, l, Vec2(5, 3));
  EdgeBearing bearing(robot, l, std::atan2(3, 5) - 0.25 + 2.0 * M_PI);
  EdgePointCalibration calibration(robot, l, std::make_shared<VertexSE2>(Vec2(1, 0), M_PI / 2), Vec2(2, -4));
  for (Edge* edge : std::initializer_list<Edge*>{&point, &without, &bearing, &calibration}) edge->ComputeResidual();
  EXPECT_LT(point.Residual().norm(), 1e-14);
  EXPECT_LT(without.Residual().norm(), 1e-14);
  EXPECT_NEAR(bearing.Residual()[0], 0.25, 1e-14);
  EXPECT_LT((calibration.Residual() - Vec2(1, 0)).norm(), 1e-14);
}

// A turn of 350° is one of −10°.
TEST_F(SensorOnAPose, AnglesGoTheShorterWayRound) {
  const auto i = std::make_shared<VertexSE2>(Vec2(0, 0), -3.0), j = std::make_shared<VertexSE2>(Vec2(0, 0), 3.0);
  EdgeOffset<VertexSE2> edge(i, j, Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 0));
  edge.ComputeResidual();
  EXPECT_NEAR(edge.Residual()[2], 6.0 - 2.0 * M_PI, 1e-14);
}

// Without offsets it is the plain edge, in space and in the plane; with them it is zero where the sensors stand as measured.
TEST_F(SensorOnAPose, OffsetsAgreeWithPlainTransforms) {
  const auto i = InPlane(), j = InPlane();
  const auto I = InSpace(), J = InSpace(), Z = InSpace();
  const auto z = InPlane();
  const Vec3 none = Vec3::Zero();
  EdgeOffset<VertexSE2> offset(i, j, z->GetEstimate(), none, none);
  EdgeSE2Between plain(i, j, z->p(), z->Theta());
  const Vec7 nothing = NoOffset(I.get());
  EdgeOffset<VertexPose> offset_in_space(I, J, Z->GetEstimate(), nothing, nothing);
  EdgeSE3Between plain_in_space(I, J, Z->q(), Z->p());
  for (Edge* edge : std::initializer_list<Edge*>{&offset, &plain, &offset_in_space, &plain_in_space}) edge->Linearize();
  EXPECT_LT((offset.Residual() - plain.Residual()).norm(), 1e-13);
  EXPECT_LT((offset_in_space.Residual() - plain_in_space.Residual()).norm(), 1e-13);
  EXPECT_LT((offset_in_space.Jacobian(1) - plain_in_space.Jacobian(1)).norm(), 1e-13);

  const Transform T_I{I->q(), I->p()}, T_J{J->q(), J->p()};
  const auto s = InSpace(), t = InSpace();
  const Transform T_s{s->q(), s->p()}, T_t{t->q(), t->p()}, measured = Inverse(T_I * T_s) * (T_J * T_t);
  const VertexPose T_z(measured.q, measured.p);
  EdgeOffset<VertexPose> exact(I, J, T_z.GetEstimate(), s->GetEstimate(), t->GetEstimate());
  exact.ComputeResidual();
  EXPECT_LT(exact.Residual().norm(), 1e-13);
  const Transform T_I_J = Inverse(T_I) * T_J;
  EXPECT_LT((exact.Measurement().head<3>() - T_I_J.p).norm(), 1e-13);
}

}  // namespace
}  // namespace ch5
