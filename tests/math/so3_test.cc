/// The rotation group against its defining power series in extended precision, and against itself.
#include "ch5_backend/math/so3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

using Mat33L = Eigen::Matrix<long double, 3, 3>;

// Both sides of every threshold in so3.cc, and angles from nothing to half a turn.
const std::vector<double> kAngles = {0.0,     1e-200,  1e-12,   0.99e-8, 1.01e-8, 1e-6,      0.99e-4,
                                     1.01e-4, 1.99e-4, 2.01e-4, 1e-3,    0.05,    0.1999999, 0.2000001,
                                     0.5,     1.0,     2.0,     3.0,     3.14};

Vec3 RandomAxis(Random* random) { return NormalVector(random, 1.0).normalized(); }

// Σ [θ]ⁿ / (n + offset)!:  R = Exp(θ) for offset 0, J_l(θ) for offset 1. Forty terms reach 1e-19 for ‖θ‖ ≤ π.
Mat33 PowerSeries(const Vec3& theta, int offset) {
  const Mat33L A = Hat(theta).cast<long double>();
  Mat33L sum = Mat33L::Identity(), term = Mat33L::Identity();
  for (int n = 1; n <= 40; ++n) {
    term = term * A / static_cast<long double>(n + offset);
    sum += term;
  }
  return sum.cast<double>();
}

double Distance(const Mat33& A, const Mat33& B) { return (A - B).cwiseAbs().maxCoeff(); }

TEST(SO3, ExpAndLeftJacobianEqualTheirPowerSeries) {
  Random random(1);
  for (const double angle : kAngles) {
    for (int k = 0; k < 10; ++k) {
      const Vec3 theta = angle * RandomAxis(&random);
      // A few roundings of numbers up to 1: 1e-15 is 4.5 of them.
      EXPECT_LT(Distance(ExpSO3(theta).toRotationMatrix(), PowerSeries(theta, 0)), 2e-15) << angle;
      EXPECT_LT(Distance(LeftJacobianSO3(theta), PowerSeries(theta, 1)), 1e-15) << angle;
      EXPECT_LT(Distance(RightJacobianSO3(theta), PowerSeries(-theta, 1)), 1e-15) << angle;
    }
  }
}

TEST(SO3, RightJacobianInverseInvertsTheRightJacobian) {
  Random random(2);
  for (const double angle : kAngles) {
    const Vec3 theta = angle * RandomAxis(&random);
    const Mat33 product = RightJacobianSO3(theta) * RightJacobianInverseSO3(theta);
    EXPECT_LT(Distance(product, Mat33::Identity()), 4e-15) << angle;
  }
  // Beyond half a turn up to 2π, where the inverse ceases to exist.
  const Vec3 theta = 6.0 * RandomAxis(&random);
  EXPECT_LT(Distance(RightJacobianSO3(theta) * RightJacobianInverseSO3(theta), Mat33::Identity()), 1e-13);
}

TEST(SO3, LogUndoesExpToTheLastDigitsOfTheAngle) {
  Random random(3);
  for (const double angle : kAngles) {
    for (int k = 0; k < 10; ++k) {
      const Vec3 theta = angle * RandomAxis(&random);
      EXPECT_LE((LogSO3(ExpSO3(theta)) - theta).norm(), 1e-15 * angle) << angle;
    }
  }
}

TEST(SO3, ExpUndoesLogUpToTheQuaternionsSign) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    Eigen::Vector4d coeffs = NormalVector<4>(&random, 1.0);
    if (k % 4 == 0) coeffs[3] *= 1e-12;  // close to half a turn, on either side
    const Qd q(coeffs.normalized());
    const Qd back = ExpSO3(LogSO3(q));
    const double sign = back.coeffs().dot(q.coeffs()) < 0.0 ? -1.0 : 1.0;
    EXPECT_LT((sign * back.coeffs() - q.coeffs()).norm(), 1e-15);
  }
}

TEST(SO3, QuaternionAndItsNegativeHaveTheSameLogWithinHalfATurn) {
  Random random(5);
  for (const double w : {0.0, 1e-300, 1e-16, 1e-8, 0.1, 0.99999999, 1.0}) {
    for (const double sign : {1.0, -1.0}) {
      const Vec3 v = std::sqrt(1.0 - w * w) * RandomAxis(&random);
      const Qd q(sign * w, v.x(), v.y(), v.z()), negative(-sign * w, -v.x(), -v.y(), -v.z());
      EXPECT_LE(LogSO3(q).norm(), M_PI * (1.0 + 1e-15));
      if (w > 0.0) {
        EXPECT_EQ(LogSO3(q), LogSO3(negative)) << w;
      } else {  // exactly half a turn: both axes are right
        EXPECT_NEAR(LogSO3(q).norm(), M_PI, 1e-15);
        EXPECT_NEAR(LogSO3(negative).norm(), M_PI, 1e-15);
      }
    }
  }
}

TEST(SO3, RotationBetweenTurnsOneDirectionIntoTheOther) {
  for (const Vec3& a : {Vec3(1, 2, 3), Vec3(0, 0, 9.81), Vec3(1e-3, 0, -9.81), Vec3(1e-5, 2e-5, -9.81),
                        Vec3(1e-7, 0, -9.81), Vec3(0, 0, -9.81), Vec3(-4, 0, 1)}) {
    const Vec3 b(0.0, 0.0, 2.0);
    const Qd q = RotationBetween(a, b);
    EXPECT_NEAR(q.norm(), 1.0, 1e-12);
    EXPECT_LT((q * a.normalized() - Vec3::UnitZ()).norm(), 4e-8) << a.transpose();  // √ε near half a turn
    EXPECT_NEAR(q.z(), 0.0, 1e-15);                                                 // no turn about b on the way
  }
}

TEST(SO3, HatIsTheCrossProduct) {
  const Vec3 a(1, 2, 3), b(-4, 5, 7);
  EXPECT_EQ(Hat(a) * b, a.cross(b));
  EXPECT_EQ(Hat(a) * b, Vec3(-1, -19, 13));
}

}  // namespace
}  // namespace ch5
