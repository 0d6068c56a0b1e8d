#include "ch5_backend/evaluate/nees.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

// By hand: 3 m and 4 m at σ = 1 m, and 0.2 rad about the vertical at σ = 0.1 rad.
TEST(Nees, OfAPoseByHand) {
  Mat66 covariance = Mat66::Identity();
  covariance.bottomRightCorner<3, 3>() *= 0.01;
  const Qd tilted = ExpSO3(Vec3(0.3, -0.2, 0.1));
  const Transform truth{tilted, Vec3(1, 1, 1)};
  const Transform estimate{ExpSO3(Vec3(0, 0, 0.2)) * tilted, Vec3(4, 5, 1)};
  const PoseConsistency pose = ComparePose(estimate, covariance, truth);
  EXPECT_LT((pose.error.head<3>() - Vec3(3, 4, 0)).norm(), 1e-12);
  EXPECT_NEAR(pose.error.tail<3>().norm(), 0.2, 1e-12);
  EXPECT_NEAR(pose.nees, 25.0 + 4.0, 1e-9);
  EXPECT_NEAR(pose.yaw_error, 0.2, 1e-12);
  EXPECT_NEAR(pose.yaw_variance, 0.01, 1e-12);
  EXPECT_NEAR(pose.YawNees(), 4.0, 1e-9);
}

TEST(Nees, OfAnIndefiniteCovarianceIsNoNumber) {
  Mat66 covariance = Mat66::Identity();
  covariance(2, 2) = -1e-12;
  EXPECT_TRUE(std::isnan(ComparePose({Qd::Identity(), Vec3(0, 0, 1)}, covariance, {}).nees));
}

// Errors drawn from the claimed covariance are consistent; claiming half the σ is overconfident by a factor of four.
TEST(Nees, OfErrorsWithTheClaimedCovarianceLiesInTheBand) {
  constexpr int kRuns = 500;
  Random random(5);
  Mat66 root = Mat66::Zero();
  root.diagonal() << 0.1, 0.2, 0.3, 0.01, 0.02, 0.01;
  root(1, 0) = 0.1;
  root(4, 2) = 0.005;
  const Mat66 covariance = root * root.transpose(), too_small = 0.25 * covariance;
  double consistent = 0.0, overconfident = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const Vec6 e = root * NormalVector<6>(&random, 1.0);
    const Transform estimate{ExpSO3(e.tail<3>()), e.head<3>()};
    consistent += ComparePose(estimate, covariance, {}).nees / kRuns;
    overconfident += ComparePose(estimate, too_small, {}).nees / kRuns;
  }
  EXPECT_TRUE(ChiSquaredBand(6, kRuns).Contains(consistent)) << consistent;
  EXPECT_GT(overconfident, ChiSquaredBand(6, kRuns).high);
  EXPECT_NEAR(overconfident, 4.0 * consistent, 1e-9 * overconfident);
}

// Tables of the χ² distribution: dof 10 and 100, at 2.5 % and 97.5 %; the approximation is good to 1 % at 10.
TEST(Nees, BandIsThatOfTheTables) {
  EXPECT_NEAR(ChiSquaredBand(1, 10).low, 0.3247, 5e-3);
  EXPECT_NEAR(ChiSquaredBand(1, 10).high, 2.0483, 5e-3);
  EXPECT_NEAR(10.0 * ChiSquaredBand(10, 10).low, 74.222, 1e-2);
  EXPECT_NEAR(10.0 * ChiSquaredBand(10, 10).high, 129.561, 1e-2);
}

}  // namespace
}  // namespace ch5
