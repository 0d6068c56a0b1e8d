// The right formulas of stage 8 against differences: its checks compare a student's derivatives with these formulas alone.

#include <gtest/gtest.h>

#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/right/open_tasks.h"

namespace ch5::homework::right {
namespace {

constexpr double kTolerance = 1e-8;  // what Differences is exact to

Transform RandomPose(Random* random) { return {ExpSO3(RandomMatrix(3, 1, random)), Vec3(RandomMatrix(3, 1, random))}; }

// [δp, δθ]: p + δp, q ⊗ Exp(δθ).
Transform Moved(const Transform& T, const VecX& delta) {
  return {T.q * ExpSO3(delta.tail<3>()), T.p + delta.head<3>()};
}

void ExpectJacobian(const Formula& over_position, const Formula& over_rotation, const MatXX& differences) {
  EXPECT_TRUE(Equal(Value(over_position.right), differences.leftCols(3), kTolerance));
  EXPECT_TRUE(Equal(Value(over_rotation.right), differences.rightCols(3), kTolerance));
}

TEST(OpenTasksFormulas, DifferentiateTheProjection) {
  Random random(1);
  for (int k = 0; k < 5; ++k) {
    const Transform T_W_B = RandomPose(&random), T_B_C = RandomPose(&random);
    const Vec3 p_C(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(2, 4));
    const Vec3 p_W = T_W_B.p + T_W_B.q * (T_B_C.p + T_B_C.q * p_C);
    const auto project = [&](const Transform& T, const Vec3& p) -> MatXX {
      return Vec3(T_B_C.q.conjugate() * (T.q.conjugate() * (p - T.p) - T_B_C.p)).hnormalized();
    };
    const Projection right(T_W_B, T_B_C, p_W);
    ExpectJacobian(right.over_position, right.over_rotation,
                   Differences(6, [&](const VecX& delta) { return project(Moved(T_W_B, delta), p_W); }));
    EXPECT_TRUE(Equal(Value(right.over_point.right),
                      Differences(3, [&](const VecX& delta) { return project(T_W_B, p_W + delta); }), kTolerance));
  }
}

TEST(OpenTasksFormulas, DifferentiateTheRange) {
  Random random(2);
  for (int k = 0; k < 5; ++k) {
    const Transform T_W_B = RandomPose(&random);
    const Vec3 antenna = RandomMatrix(3, 1, &random), beacon = Vec3(4, 0, 0) + Vec3(RandomMatrix(3, 1, &random));
    const auto residual = [&](const VecX& delta) -> MatXX {
      const Transform T = Moved(T_W_B, delta);
      return MatXX::Constant(1, 1, (T.p + T.q * antenna - beacon).norm() - 3.0);
    };
    const Range right(T_W_B, antenna, beacon, 3.0);
    EXPECT_TRUE(Equal(Value(right.residual.right), residual(VecX::Zero(6)), 1e-12));
    ExpectJacobian(right.over_position, right.over_rotation, Differences(6, residual));
  }
}

// What a step makes of the state moved by [δp, δθ, δv] and measured with [n_a, n_g] more, as a step from `origin`.
VecX AfterStep(const ImuStep& step, const VecX& delta, const VecX& noise, const ImuIncrement& origin) {
  const Transform T = Moved({step.before.q, step.before.p}, delta.head<6>());
  const Vec3 v = step.before.v + delta.tail<3>(), R_a = T.q * (step.a + noise.head<3>());
  const Qd q = T.q * ExpSO3(step.dt * (step.w + noise.tail<3>()));
  const Vec3 p = T.p + step.dt * v + 0.5 * step.dt * step.dt * R_a;
  return (VecX(9) << p - origin.p, LogSO3(origin.q.conjugate() * q), v + step.dt * R_a - origin.v).finished();
}

TEST(OpenTasksFormulas, DifferentiateAnImuStep) {
  Random random(3);
  for (int k = 0; k < 5; ++k) {
    const Transform T = RandomPose(&random);
    ImuStep step;
    step.before = {T.p, T.q, RandomMatrix(3, 1, &random), RandomPositiveDefinite(9, &random)};
    step.a = 3.0 * RandomMatrix(3, 1, &random);
    step.w = 2.0 * RandomMatrix(3, 1, &random);
    step.dt = 0.25, step.sigma_a = 0.15, step.sigma_g = 0.07;
    const Integrated right(step);
    const VecX still = VecX::Zero(9), exact = VecX::Zero(6);
    const ImuIncrement after{Value(right.p.right), Qd(Mat33(Value(right.R.right))), Value(right.v.right), {}};
    EXPECT_LT(AfterStep(step, still, exact, after).norm(), 1e-12);
    const MatXX A = Differences(9, [&](const VecX&delta) { return AfterStep(step, delta, exact, after); }),
                B = Differences(6, [&](const VecX&noise) { return AfterStep(step, still, noise, after); });
    VecX Q(6);  // of noise that acts for dt
    Q << Vec3::Constant(step.sigma_a * step.sigma_a / step.dt), Vec3::Constant(step.sigma_g * step.sigma_g / step.dt);
    EXPECT_TRUE(Equal(Value(right.covariance.right),
                      A * step.before.covariance * A.transpose() + B * Q.asDiagonal() * B.transpose(), kTolerance));
  }
}

}  // namespace
}  // namespace ch5::homework::right
