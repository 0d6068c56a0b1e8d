/// Every analytic Jacobian against central differences: at the identity, at small angles on both sides of the
/// thresholds of the series in so3.cc, at random states, and with a large residual.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/bal/edge_bal.h"
#include "ch5_backend/types/edge_curve_fitting.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/visual/edge_reprojection.h"
#include "ch5_backend/types/visual/edge_stereo.h"
#include "tests/derivatives.h"

namespace ch5 {
namespace {

const std::vector<double> kAngles = {0.0,     1e-12, 0.99e-8, 1.01e-8, 0.99e-4, 1.01e-4, 1.99e-4,
                                     2.01e-4, 1e-3,  0.1999,  0.2001,  1.0,     3.0};
const std::vector<Vec2> kOffsets = {{0, 0}, {0.01, -0.02}, {50, -30}};  // residuals from none to absurd

std::shared_ptr<VertexPose> RandomPose(double angle, Random* random) {
  return std::make_shared<VertexPose>(ExpSO3(angle * NormalVector(random, 1.0).normalized()),
                                      NormalVector(random, 0.3));
}

std::string Where(double angle, const Vec2& offset) {
  return "angle " + std::to_string(angle) + ", residual " + std::to_string(offset.norm());
}

// A landmark two to five meters ahead of its host, which all nearby cameras see.
struct Sight {
  explicit Sight(Random* random)
      : inverse_depth(std::make_shared<VertexInverseDepth>(1.0 / random->Uniform(2.0, 5.0))),
        u_host(random->Uniform(-0.5, 0.5), random->Uniform(-0.5, 0.5)) {}
  std::shared_ptr<VertexInverseDepth> inverse_depth;
  Vec2 u_host;
};

// At large angles a landmark may lie near a camera's plane, where central differences are no oracle.
bool CheckIfSeen(Edge* edge, const std::string& where) {
  edge->ComputeResidual();
  const bool seen = edge->Residual().allFinite() && edge->Residual().norm() < 100.0;
  if (seen) ExpectJacobiansAreDerivatives(edge, where);
  return seen;
}

TEST(Jacobian, ReprojectionOfAnInverseDepth) {
  Random random(1);
  int seen = 0;
  for (const double angle : kAngles) {
    for (const Vec2& offset : kOffsets) {
      const Sight sight(&random);
      const Transform T_B_C = {ExpSO3(angle * NormalVector(&random, 1.0).normalized()), NormalVector(&random, 0.1)};
      EdgeReprojection edge(sight.inverse_depth, RandomPose(angle, &random), RandomPose(0.3 * angle, &random),
                            sight.u_host, offset, T_B_C);
      seen += CheckIfSeen(&edge, Where(angle, offset));
      EdgeReprojectionExtrinsic with_extrinsic(sight.inverse_depth, RandomPose(angle, &random),
                                               RandomPose(0.3 * angle, &random), RandomPose(angle, &random),
                                               sight.u_host, offset);
      seen += CheckIfSeen(&with_extrinsic, Where(angle, offset));
    }
  }
  EXPECT_GE(seen, 70);  // of 78
}

// The camera being calibrated: extrinsic and time offset, with points that move in both images. Then a second camera: in
// another frame than the host's, and in the host's own.
TEST(Jacobian, ReprojectionWithACalibrationAndIntoASecondCamera) {
  Random random(8);
  int seen = 0;
  for (const double angle : kAngles) {
    const Sight sight(&random);
    const MovingPoint host{sight.u_host, Vec2(0.4, -0.3), 0.01}, target{Vec2(0.1, 0.2), Vec2(-0.6, 0.5), -0.02};
    const auto pose_i = RandomPose(angle, &random), pose_j = RandomPose(0.3 * angle, &random);
    const auto camera0 = RandomPose(angle, &random), camera1 = RandomPose(0.5 * angle, &random);
    const auto time_offset = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.03));
    EdgeReprojectionCalibration one(sight.inverse_depth, pose_i, pose_j, camera0, time_offset, host, target);
    EdgeStereo two(sight.inverse_depth, pose_i, pose_j, camera0, camera1, time_offset, host, target);
    EdgeStereoHost in_host(sight.inverse_depth, camera0, camera1, time_offset, host, target);
    for (Edge* edge : std::initializer_list<Edge*>{&one, &two, &in_host})
      seen += CheckIfSeen(edge, Where(angle, target.x));
  }
  EXPECT_GE(seen, 30);  // of 39
}

TEST(Jacobian, ReprojectionOfAPointInSpace) {
  Random random(2);
  for (const double angle : kAngles) {
    for (const Vec2& offset : kOffsets) {
      const auto T_W_B = RandomPose(angle, &random);
      const Transform T_B_C = {ExpSO3(angle * NormalVector(&random, 1.0).normalized()), NormalVector(&random, 0.1)};
      const Vec3 p_C = NormalVector(&random, 0.5) + Vec3(0, 0, 4);
      const Vec3 p_W = T_W_B->q() * (T_B_C.q * p_C + T_B_C.p) + T_W_B->p();
      EdgeReprojectionXYZ edge(std::make_shared<VertexPointXYZ>(p_W), T_W_B, offset, T_B_C);
      EdgeReprojectionPoseOnly pose_only(T_W_B, p_W, offset, T_B_C);
      ExpectJacobiansAreDerivatives(&edge, Where(angle, offset));
      ExpectJacobiansAreDerivatives(&pose_only, Where(angle, offset));
      // By hand: the two edges share the residual p_C.xy/p_C.z − u and the pose's Jacobian.
      EXPECT_LT((edge.Residual() - (p_C.head<2>() / p_C.z() - offset)).norm(), 1e-13 * (1.0 + offset.norm()));
      EXPECT_LT((edge.Jacobian(1) - pose_only.Jacobian(0)).norm(), 1e-13);
    }
  }
}

TEST(Jacobian, PriorOnAPose) {
  Random random(3);
  for (const double angle : kAngles) {
    for (const double distance : {0.0, 1e-6, 100.0}) {
      const auto pose = RandomPose(1.0, &random);
      EdgeSE3Prior edge(pose, pose->q() * ExpSO3(angle * NormalVector(&random, 1.0).normalized()),
                        pose->p() + distance * Vec3(1, 2, 3));
      ExpectJacobiansAreDerivatives(&edge, "angle " + std::to_string(angle));
      EXPECT_NEAR(edge.Residual().head<3>().norm(), angle, 1e-14);
      EXPECT_NEAR(edge.Residual().tail<3>().norm(), distance * std::sqrt(14.0), 1e-12);
      // The other sign of the quaternion asks for the same pose.
      const VecX residual = edge.Residual();
      const VecX x = pose->Parameters();
      pose->Parameters().tail<4>() = -x.tail<4>();
      edge.ComputeResidual();
      EXPECT_LT((edge.Residual() - residual).norm(), 1e-15);
    }
  }
}

TEST(Jacobian, ObservationOfABalCamera) {
  Random random(4);
  for (const double angle : kAngles) {
    for (const Vec2& offset : {Vec2(0, 0), Vec2(3, -2), Vec2(1e4, -3e3)}) {
      Vec9 camera;
      camera << angle * NormalVector(&random, 1.0).normalized(), NormalVector(&random, 0.5), 500.0,
          0.05 * random.Normal(), 0.01 * random.Normal();
      const Vec3 P = NormalVector(&random, 0.5) + Vec3(0, 0, -4);  // a BAL camera looks along −z
      const Vec3 X = ExpSO3(camera.head<3>()).conjugate() * (P - camera.segment<3>(3));
      EdgeBAL edge(std::make_shared<VertexCameraBAL>(camera), std::make_shared<VertexPointXYZ>(X), offset);
      ExpectJacobiansAreDerivatives(&edge, Where(angle, offset));
    }
  }
}

TEST(Jacobian, CurveFitting) {
  for (const double x : {0.0, 0.3, 1.0}) {
    for (const Vec3& abc : {Vec3(0, 0, 0), Vec3(1, 2, 1), Vec3(-1, 0.5, 3)}) {
      for (const double y : {0.0, 1.0, 1e3}) {
        EdgeCurveFitting edge(std::make_shared<VertexVector<3>>(abc), x, y);
        ExpectJacobiansAreDerivatives(&edge, "x = " + std::to_string(x));
      }
    }
  }
}

TEST(Vertex, QuaternionKeepsUnitLengthOverManyUpdates) {
  Random random(6);
  VertexPose pose;
  double worst = 0.0;
  for (int i = 0; i < 100000; ++i) {
    Vec6 delta;
    delta << NormalVector(&random, 1.0), NormalVector(&random, 1.0);
    pose.Plus(delta.data());
    worst = std::max(worst, std::abs(pose.q().norm() - 1.0));
  }
  EXPECT_LT(worst, 4e-16);  // two roundings; without normalizing the drift is some 1e-14
  EXPECT_GT(pose.p().norm(), 1.0);
}

}  // namespace
}  // namespace ch5
