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

Vec3 RandomVec3(Random* random, double sigma = 1.0) {
  Vec3 v;
  for (double& x : v) x = sigma * random->Normal();
  return v;
}

std::shared_ptr<VertexPose> RandomPose(double angle, Random* random) {
  return std::make_shared<VertexPose>(ExpSO3(angle * RandomVec3(random).normalized()), RandomVec3(random, 0.3));
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
      const Transform T_B_C = {ExpSO3(angle * RandomVec3(&random).normalized()), RandomVec3(&random, 0.1)};
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

// The camera being calibrated: extrinsic and time offset, with points that move in both images.
TEST(Jacobian, ReprojectionWithACalibration) {
  Random random(7);
  int seen = 0;
  for (const double angle : kAngles) {
    const Sight sight(&random);
    const MovingPoint host{sight.u_host, Vec2(0.4, -0.3), 0.01}, target{Vec2(0.1, 0.2), Vec2(-0.6, 0.5), -0.02};
    EdgeReprojectionCalibration edge(sight.inverse_depth, RandomPose(angle, &random), RandomPose(0.3 * angle, &random),
                                     RandomPose(angle, &random),
                                     std::make_shared<VertexScalar>(VertexScalar::Estimate(0.03)), host, target);
    seen += CheckIfSeen(&edge, Where(angle, target.x));
  }
  EXPECT_GE(seen, 10);  // of 13
}

// A second camera: in another frame than the host's, and in the host's own.
TEST(Jacobian, ReprojectionIntoASecondCamera) {
  Random random(8);
  int seen = 0;
  for (const double angle : kAngles) {
    const Sight sight(&random);
    const MovingPoint host{sight.u_host, Vec2(0.4, -0.3), 0.01}, target{Vec2(0.1, 0.2), Vec2(-0.6, 0.5), -0.02};
    const auto time_offset = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.03));
    EdgeStereo edge(sight.inverse_depth, RandomPose(angle, &random), RandomPose(0.3 * angle, &random),
                    RandomPose(angle, &random), RandomPose(0.5 * angle, &random), time_offset, host, target);
    seen += CheckIfSeen(&edge, Where(angle, target.x));
    EdgeStereoHost in_host(sight.inverse_depth, RandomPose(angle, &random), RandomPose(0.5 * angle, &random),
                           time_offset, host, target);
    seen += CheckIfSeen(&in_host, Where(angle, target.x));
  }
  EXPECT_GE(seen, 20);  // of 26
}

TEST(Jacobian, ReprojectionAtTheIdentity) {
  const auto pose = [] { return std::make_shared<VertexPose>(); };
  const auto inverse_depth = std::make_shared<VertexInverseDepth>(0.25);
  EdgeReprojection inverse(inverse_depth, pose(), pose(), Vec2(0.1, -0.2), Vec2(0.1, -0.2));
  ExpectJacobiansAreDerivatives(&inverse, "identity");
  EXPECT_EQ(inverse.Residual().norm(), 0.0);
  EdgeReprojectionExtrinsic extrinsic(inverse_depth, pose(), pose(), pose(), Vec2(0.1, -0.2), Vec2(0.1, -0.2));
  ExpectJacobiansAreDerivatives(&extrinsic, "identity");
  EdgeReprojectionXYZ xyz(std::make_shared<VertexPointXYZ>(Vec3(0.4, -0.8, 4.0)), pose(), Vec2(0.1, -0.2));
  ExpectJacobiansAreDerivatives(&xyz, "identity");
  EXPECT_EQ(xyz.Residual().norm(), 0.0);
  EdgeReprojectionPoseOnly pose_only(pose(), Vec3(0.4, -0.8, 4.0), Vec2(0.1, -0.2));
  ExpectJacobiansAreDerivatives(&pose_only, "identity");
}

TEST(Jacobian, ReprojectionOfAPointInSpace) {
  Random random(2);
  for (const double angle : kAngles) {
    for (const Vec2& offset : kOffsets) {
      const auto T_W_B = RandomPose(angle, &random);
      const Transform T_B_C = {ExpSO3(angle * RandomVec3(&random).normalized()), RandomVec3(&random, 0.1)};
      const Vec3 p_C = RandomVec3(&random, 0.5) + Vec3(0, 0, 4);
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
      EdgeSE3Prior edge(pose, pose->q() * ExpSO3(angle * RandomVec3(&random).normalized()),
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
      camera << angle * RandomVec3(&random).normalized(), RandomVec3(&random, 0.5), 500.0, 0.05 * random.Normal(),
          0.01 * random.Normal();
      const Vec3 P = RandomVec3(&random, 0.5) + Vec3(0, 0, -4);  // a BAL camera looks along −z
      const Vec3 X = ExpSO3(camera.head<3>()).conjugate() * (P - camera.segment<3>(3));
      EdgeBAL edge(std::make_shared<VertexCameraBAL>(camera), std::make_shared<VertexPointXYZ>(X), offset);
      ExpectJacobiansAreDerivatives(&edge, Where(angle, offset));
    }
  }
}

// f = 2, k1 = 0.5, k2 = 0.25 and P = (1, 2, −2): p = (0.5, 1), ‖p‖² = 1.25, d = 2.015625, u = 2 d p.
TEST(Jacobian, BalProjectionByHand) {
  const Vec9 camera = (Vec9() << 0, 0, 0, 0, 0, -6, 2, 0.5, 0.25).finished();
  EdgeBAL edge(std::make_shared<VertexCameraBAL>(camera), std::make_shared<VertexPointXYZ>(Vec3(1, 2, 4)), Vec2(1, 2));
  edge.ComputeResidual();
  EXPECT_EQ(edge.GetResidual(), Vec2(2.015625 - 1.0, 4.03125 - 2.0));
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

// An edge without Jacobians of its own falls back on the numeric ones.
class NumericReprojection : public EdgeReprojection {
 public:
  using EdgeReprojection::EdgeReprojection;
  void ComputeJacobians() override { Edge::ComputeJacobians(); }  // NOLINT: the default, past EdgeReprojection's own
};

TEST(Jacobian, NumericDefaultEqualsTheAnalyticOneAndLeavesTheStateAlone) {
  Random random(5);
  const Sight sight(&random);
  const auto pose_i = RandomPose(0.4, &random), pose_j = RandomPose(0.2, &random);
  EdgeReprojection analytic(sight.inverse_depth, pose_i, pose_j, sight.u_host, Vec2(0.3, 0.1));
  NumericReprojection numeric(sight.inverse_depth, pose_i, pose_j, sight.u_host, Vec2(0.3, 0.1));
  analytic.ComputeResidual();
  analytic.ComputeJacobians();
  const VecX before = pose_i->Parameters();
  numeric.ComputeJacobians();
  EXPECT_EQ(pose_i->Parameters(), before);
  EXPECT_EQ(numeric.Residual(), analytic.Residual());
  for (size_t i = 0; i < 3; ++i) EXPECT_LT((numeric.Jacobian(i) - analytic.Jacobian(i)).norm(), 1e-6) << i;
}

TEST(Vertex, QuaternionKeepsUnitLengthOverManyUpdates) {
  Random random(6);
  VertexPose pose;
  double worst = 0.0;
  for (int i = 0; i < 100000; ++i) {
    Vec6 delta;
    delta << RandomVec3(&random), RandomVec3(&random);
    pose.Plus(delta.data());
    worst = std::max(worst, std::abs(pose.q().norm() - 1.0));
  }
  EXPECT_LT(worst, 4e-16);  // two roundings; without normalizing the drift is some 1e-14
  EXPECT_GT(pose.p().norm(), 1.0);
}

TEST(Vertex, PoseNormalizesItsQuaternionAndRefusesZero) {
  const VertexPose pose(Qd(2, 0, 0, 0), Vec3(1, 2, 3));
  EXPECT_EQ(pose.q().coeffs(), Qd::Identity().coeffs());
  EXPECT_THROW(VertexPose(Qd(0, 0, 0, 0), Vec3::Zero()), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
