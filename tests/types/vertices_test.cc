/// The vertices' ⊞ and ⊟: where an increment acts, what stays on the manifold, and the derivative of ⊟.
#include "ch5_backend/types/vertices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/pose_graph/vertex_se2.h"

namespace ch5 {
namespace {

// Both sides of the thresholds of the series in so3.cc, and nearly half a turn.
const std::vector<double> kTurns = {0.0, 1e-12, 0.99e-8, 1.01e-8, 0.99e-4, 1.01e-4, 0.199, 0.201, 1.0, 3.1};

Vec3 Direction(Random* random) { return NormalVector(random, 1.0).normalized(); }

Vec6 Increment(const Vec3& dp, const Vec3& dtheta) {
  Vec6 delta;
  delta << dp, dtheta;
  return delta;
}

// Central differences of (x ⊞ δ) ⊟ x₀ in δ at 0.
MatXX NumericMinusJacobian(Vertex* vertex, const VecX& x0) {
  const int n = vertex->LocalDimension();
  MatXX J(n, n);
  const VecX x = vertex->Parameters();
  const double h = 1e-5;
  for (int k = 0; k < n; ++k) {
    VecX ends[2];
    for (const int side : {0, 1}) {
      const VecX delta = (side ? h : -h) * VecX::Unit(n, k);
      vertex->Plus(delta.data());
      ends[side] = vertex->Minus(x0);
      vertex->Parameters() = x;
    }
    J.col(k) = (ends[1] - ends[0]) / (2.0 * h);
  }
  return J;
}

// By hand: R_z(90°) R_x(90°) takes e_x to e_y, e_y by e_z to e_z, e_z by −e_y to e_x. The position moves along W's axes.
TEST(VertexPose, TurnsAboutTheBodysAxesAndMovesAlongTheWorlds) {
  VertexPose pose(Qd(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ())), Vec3(1, 2, 3));
  const Vec6 delta = Increment(Vec3(0.5, 0, 0), Vec3(M_PI / 2, 0, 0));
  pose.Plus(delta.data());
  EXPECT_EQ(pose.p(), Vec3(1.5, 2, 3));
  EXPECT_LT((pose.R() * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((pose.R() * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-15);
  EXPECT_LT((pose.R() * Vec3::UnitZ() - Vec3::UnitX()).norm(), 1e-15);
}

// (x ⊞ δ) ⊟ x = [δp; 2 sin(‖δθ‖/2) δθ/‖δθ‖]: δ itself up to the third order.
TEST(VertexPose, MinusUndoesPlusUpToTheThirdOrder) {
  Random random(22);
  for (const double angle : kTurns) {
    VertexPose pose(ExpSO3(NormalVector(&random, 1.0)), NormalVector(&random, 2.0));
    const VecX x0 = pose.Parameters();
    const Vec3 dp = NormalVector(&random, 1.0), axis = Direction(&random);
    const Vec6 delta = Increment(dp, angle * axis);
    pose.Plus(delta.data());
    EXPECT_LT((pose.Minus(x0) - Increment(dp, 2.0 * std::sin(0.5 * angle) * axis)).norm(), 2e-15) << angle;
    VecX negated = x0;  // −q₀ is the same rotation
    negated.tail<4>() *= -1.0;
    EXPECT_EQ(pose.Minus(negated), pose.Minus(x0));
  }
}

TEST(VertexPose, MinusJacobianIsTheDerivative) {
  Random random(23);
  for (const double angle : kTurns) {
    const Qd q0 = ExpSO3(NormalVector(&random, 1.0));
    const Vec3 p0 = NormalVector(&random, 2.0);
    VertexPose pose(q0 * ExpSO3(angle * Direction(&random)), p0 + Vec3(1, 2, 3));
    const VecX x0 = VertexPose(q0, p0).Parameters();
    EXPECT_LT((pose.MinusJacobian(x0) - NumericMinusJacobian(&pose, x0)).norm(), 1e-9) << angle;
  }
  VertexPose pose(ExpSO3({0.1, 0.2, 0.3}), Vec3::Ones());
  EXPECT_LT((pose.MinusJacobian(pose.Parameters()) - MatXX::Identity(6, 6)).norm(), 1e-15);
}

// e_zᵀ J_l⁻¹(Δφ) R δθ = 0 keeps the yaw of Zhang's (2018) gauge to rounding, over a thousand steps of 0.1 rad.
TEST(VertexReferencePose, StepsWithoutYawKeepTheYaw) {
  Random random(24);
  const Qd q = ExpSO3({0.3, -0.2, 0.5});
  VertexReferencePose reference(q, Vec3(1, 2, 3));
  VertexPose plain(q, Vec3(1, 2, 3));
  double yaw_of_plain = 0.0;
  for (int k = 0; k < 1000; ++k) {
    const auto without_yaw = [&random](const Mat33& J) -> Vec3 {
      const Vec3 row = J.row(2).transpose().normalized(), step = NormalVector(&random, 0.1);
      return step - row.dot(step) * row;
    };
    Vec3 dtheta = without_yaw(reference.DeltaPhiJacobian());
    if (reference.DeltaPhi().norm() > 1.0)
      dtheta -= 0.1 * reference.DeltaPhiJacobian().inverse() * reference.DeltaPhi();
    Vec6 delta = Increment(Vec3::Zero(), dtheta);
    reference.Plus(delta.data());
    ASSERT_LT(std::abs(reference.DeltaPhi().z()), 1e-12) << k;
    // The ordinary pose's yaw rate is e_zᵀ R δθ: without it, step by step, the yaw drifts all the same.
    dtheta = without_yaw(plain.R());
    const Vec3 phi = LogSO3(plain.q() * q.conjugate());
    if (phi.norm() > 1.0) dtheta -= 0.1 * plain.R().transpose() * phi;
    delta = Increment(Vec3::Zero(), dtheta);
    plain.Plus(delta.data());
    yaw_of_plain = std::max(yaw_of_plain, std::abs(LogSO3(plain.q() * q.conjugate()).z()));
  }
  EXPECT_GT(yaw_of_plain, 0.1);  // what the reference pose is for
}

TEST(VertexReferencePose, AgreesWithAPoseToFirstOrder) {
  Random random(25);
  double before = 0.0;
  for (const double size : {1e-2, 5e-3}) {
    VertexReferencePose reference(ExpSO3({0.3, -0.2, 0.5}), Vec3(1, 2, 3));
    const Vec6 start = Increment(Vec3(0.1, 0, 0), Vec3(0.4, -0.3, 0.2));
    reference.Plus(start.data());
    VertexPose pose(reference.q(), reference.p());
    const Vec6 delta = size * Increment(Vec3(1, 2, 3), Vec3(-2, 1, 0.5));
    reference.Plus(delta.data());
    pose.Plus(delta.data());
    EXPECT_LT((reference.p() - pose.p()).norm(), 1e-15);
    const double apart = LogSO3(pose.q().conjugate() * reference.q()).norm();
    if (before > 0.0) {
      EXPECT_NEAR(before / apart, 4.0, 0.2);  // of second order
    }
    before = apart;
  }
}

// By hand, from an anchor at the origin: 1/distance falls by 1/4 and rises by 1/2; a step across turns the ray.
TEST(VertexPointOnRay, StepsEvenlyInInverseDistance) {
  const auto moved = [](const Vec3& anchor, const Vec3& delta) {
    VertexPointOnRay point(Vec3(0, 0, 2), anchor);
    point.Plus(delta.data());
    return point.GetEstimate();
  };
  const Vec3 origin = Vec3::Zero();
  EXPECT_EQ(moved(origin, {0, 0, 1}), Vec3(0, 0, 4));
  EXPECT_EQ(moved(origin, {0, 0, -2}), Vec3(0, 0, 1));
  EXPECT_EQ(moved(origin, {3, 0, 0}), Vec3(3, 0, 2));
  EXPECT_EQ(moved(origin, {1, 0, 1}), Vec3(2, 0, 4));
  EXPECT_EQ(moved(origin, {0, 0, 2}), Vec3(0, 0, 40)) << "beyond infinity";
  EXPECT_EQ(moved({0, 0, 2}, {1, 2, 3}), Vec3(1, 2, 5)) << "at its anchor";
}

TEST(VertexPointOnRay, AddsToFirstOrder) {
  const Vec3 x(1, -2, 3);
  VertexPointOnRay point(x, Vec3(-0.5, 0.2, 0.1));
  EXPECT_LT((NumericMinusJacobian(&point, x) - MatXX::Identity(3, 3)).norm(), 1e-9);
}

TEST(VertexReferencePose, DeltaPhiJacobianIsTheDerivative) {
  Random random(26);
  for (const double angle : kTurns) {
    if (angle > 3.0) continue;  // Log jumps at half a turn
    const Qd q0 = ExpSO3(NormalVector(&random, 1.0));
    const Vec3 phi = angle * Direction(&random);
    VertexReferencePose pose(q0, Vec3::Zero());
    const double h = 1e-5;
    Mat33 numeric;
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](double step) {
        pose.SetPose(ExpSO3(phi) * q0 * ExpSO3(step * Vec3::Unit(k)), Vec3::Zero());
        return pose.DeltaPhi();
      };
      numeric.col(k) = (at(h) - at(-h)) / (2.0 * h);
    }
    pose.SetPose(ExpSO3(phi) * q0, Vec3::Zero());
    EXPECT_LT((pose.DeltaPhi() - phi).norm(), 1e-14);
    EXPECT_LT((pose.DeltaPhiJacobian() - numeric).norm(), 1e-9) << angle;
  }
}

// The rotation is kept for the step and for its undoing, and must be that of ω whatever has happened to it.
TEST(VertexCameraBAL, GivesTheRotationOfItsPresentState) {
  Random random(27);
  Vec9 x;
  x << 0.3, -0.2, 0.5, 1, 2, 3, 500, 0.1, 0.01;
  VertexCameraBAL camera(x);
  const auto expect_present = [&camera](const char* when) {
    VertexCameraBAL::Rotation other;
    const VertexCameraBAL::Rotation& rotation = camera.GetRotation(&other);
    const Vec3 omega = camera.GetEstimate().head<3>();
    EXPECT_EQ(rotation.omega, omega) << when;
    EXPECT_LT((rotation.R - ExpSO3(omega).toRotationMatrix()).norm(), 1e-15) << when;
    EXPECT_LT((rotation.J_l - LeftJacobianSO3(omega)).norm(), 1e-15) << when;
  };
  expect_present("at first");
  for (int k = 0; k < 3; ++k) {
    camera.BackUpParameters();
    const Vec9 delta = 0.1 * (Vec9() << NormalVector(&random, 1.0), NormalVector(&random, 1.0), 1, 0, 0).finished();
    camera.Plus(delta.data());
    expect_present("after a step");
    camera.RollBackParameters();
    expect_present("after its undoing");
    camera.Plus(delta.data());
    expect_present("after a step from there");
  }
  camera.SetEstimate(-x);
  expect_present("set by other means");
  EXPECT_EQ(VertexCameraBAL(x).Minus(x - Vec9::Ones()), Vec9::Ones());
}

// How states are stored.
TEST(Vertices, AreStoredInTheOrderOfTheConventions) {
  const VertexSpeedBias state((Vec9() << 1, 2, 3, 4, 5, 6, 7, 8, 9).finished());
  EXPECT_EQ(state.v(), Vec3(1, 2, 3));
  EXPECT_EQ(state.b_a(), Vec3(4, 5, 6));
  EXPECT_EQ(state.b_g(), Vec3(7, 8, 9));
  const VertexPose pose(Qd(0.5, 0.5, -0.5, 0.5), Vec3(1, 2, 3));  // stored [p; x, y, z, w]
  EXPECT_EQ(pose.Parameters(), (Vec7() << 1, 2, 3, 0.5, -0.5, 0.5, 0.5).finished());
}

// q and 3q are one rotation, and [0, 0, 0, 0] is none.
TEST(VertexPose, KeepsAUnitQuaternionHoweverItIsSet) {
  VertexPose pose;
  pose.SetEstimate((Vec7() << 1, 2, 3, 1.5, -1.5, 1.5, 1.5).finished());
  EXPECT_EQ(pose.Parameters(), (Vec7() << 1, 2, 3, 0.5, -0.5, 0.5, 0.5).finished());
  EXPECT_THROW(pose.SetEstimate(Vec7::Zero()), std::invalid_argument);
  EXPECT_THROW(VertexPose(Qd(0, 0, 0, 0), Vec3::Zero()), std::invalid_argument);
  EXPECT_EQ(pose.p(), Vec3(1, 2, 3)) << "as before";
}

// Either side of ±π; ±π are one heading, so both may stand for it.
TEST(VertexSE2, DifferencesOfHeadingsTakeTheShorterWay) {
  EXPECT_DOUBLE_EQ(WrapAngle(3.0 + 2 * M_PI), 3.0);
  EXPECT_DOUBLE_EQ(WrapAngle(-3.0 - 4 * M_PI), -3.0);
  EXPECT_DOUBLE_EQ(std::abs(WrapAngle(3 * M_PI)), M_PI);
  const VertexSE2 vertex(Vec2::Zero(), M_PI - 0.1);
  EXPECT_NEAR(vertex.Minus(Vec3(0, 0, -M_PI + 0.1))[2], -0.2, 1e-15);
  EXPECT_LT((Rotation2(M_PI / 2) * Vec2(1, 0) - Vec2(0, 1)).norm(), 1e-15);
}

}  // namespace
}  // namespace ch5
