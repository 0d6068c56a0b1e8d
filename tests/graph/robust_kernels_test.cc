#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "ch5_backend/graph/loss.h"

namespace ch5 {
namespace {

using Losses = std::map<std::string, std::shared_ptr<LossFunction>>;

Losses AllLosses(double delta) {
  const auto huber = std::make_shared<HuberLoss>(1.0);
  return {{"Trivial", std::make_shared<TrivialLoss>()},
          {"Huber", std::make_shared<HuberLoss>(delta)},
          {"PseudoHuber", std::make_shared<PseudoHuberLoss>(delta)},
          {"Cauchy", std::make_shared<CauchyLoss>(delta)},
          {"GemanMcClure", std::make_shared<GemanMcClureLoss>(delta)},
          {"Welsch", std::make_shared<WelschLoss>(delta)},
          {"Fair", std::make_shared<FairLoss>(delta)},
          {"Tukey", std::make_shared<TukeyLoss>(delta)},
          {"Saturated", std::make_shared<SaturatedLoss>(delta)},
          {"Dcs", std::make_shared<DcsLoss>(delta)},
          {"ScaleDelta", std::make_shared<ScaleDeltaLoss>(huber, delta)}};
}

// The points and tolerances of g2o's robust_kernel_tests; a derivative is compared relative to its size.
TEST(RobustKernels, DerivativesAgreeWithCentralDifferences) {
  constexpr double kDelta = 0.07;
  for (const auto& [name, loss] : AllLosses(kDelta)) {
    for (const double s : {0.99 * kDelta * kDelta, 0.99 * kDelta, 1.5 * kDelta}) {
      const double h = 1e-5 * s;
      const Rho below = loss->Evaluate(s - h), at = loss->Evaluate(s), above = loss->Evaluate(s + h);
      const double slope = (above[0] - below[0]) / (2 * h), curvature = (above[1] - below[1]) / (2 * h);
      EXPECT_NEAR(at[1], slope, 1e-5 * std::max(1.0, std::abs(slope))) << name << " at " << s;
      EXPECT_NEAR(at[2], curvature, 1e-3 * std::max(1.0, std::abs(curvature))) << name << " at " << s;
    }
  }
}

TEST(RobustKernels, SmallResidualsAreUntouchedAndLargeOnesNeverCountMore) {
  for (const auto& [name, loss] : AllLosses(0.7)) {
    const Rho zero = loss->Evaluate(0.0);
    EXPECT_EQ(zero[0], 0.0) << name;
    EXPECT_EQ(zero[1], 1.0) << name;
    EXPECT_TRUE(std::isfinite(zero[2])) << name;
    // Fair's loss leaves s by O(s^1.5), all others by O(s²).
    EXPECT_NEAR(loss->Evaluate(1e-8)[0], 1e-8, 1e-8 * 1e-3) << name;
    double last = 1.0;
    for (double s = 1e-3; s < 1e6; s *= 1.7) {
      const Rho rho = loss->Evaluate(s);
      EXPECT_LE(rho[0], s * (1 + 1e-12)) << name << " at " << s;
      EXPECT_LE(rho[1], last) << name << " at " << s;
      EXPECT_GE(rho[1], 0.0) << name << " at " << s;
      last = rho[1];
    }
  }
}

TEST(RobustKernels, LimitsWorkedByHand) {
  EXPECT_NEAR(GemanMcClureLoss(4.0).Evaluate(12.0)[0], 3.0, 1e-15);     // 4·12/16
  EXPECT_NEAR(PseudoHuberLoss(1.0).Evaluate(8.0)[0], 4.0, 1e-15);       // 2(√9 − 1)
  EXPECT_NEAR(WelschLoss(2.0).Evaluate(4.0)[0], 4 - 4 / M_E, 1e-14);    // δ²(1 − 1/e)
  EXPECT_NEAR(FairLoss(3.0).Evaluate(9.0)[0], 18 - 18 * M_LN2, 1e-14);  // 2δ²(1 − log 2)
  EXPECT_EQ(SaturatedLoss(3.0).Evaluate(100.0)[0], 9.0);
  EXPECT_NEAR(DcsLoss(2.0).Evaluate(6.0)[0], 4.0, 1e-15);   // 2(18 − 2)/8
  EXPECT_NEAR(DcsLoss(2.0).Evaluate(6.0)[1], 0.25, 1e-15);  // c = 4/8
  const ScaleDeltaLoss scaled(std::make_shared<HuberLoss>(1.0), 0.5);
  EXPECT_NEAR(scaled.Evaluate(4.0)[0], HuberLoss(0.5).Evaluate(4.0)[0], 1e-15);
}

template <typename Loss>
class Threshold : public testing::Test {};
using WithThreshold = testing::Types<HuberLoss, PseudoHuberLoss, CauchyLoss, GemanMcClureLoss, WelschLoss, FairLoss,
                                     TukeyLoss, SaturatedLoss, DcsLoss>;
TYPED_TEST_SUITE(Threshold, WithThreshold, );  // Clang wants a variadic argument, be it empty

TYPED_TEST(Threshold, MustBePositiveAndFinite) {
  for (const double bad : {0.0, -1.0, std::nan(""), static_cast<double>(INFINITY)}) {
    EXPECT_THROW(TypeParam{bad}, std::invalid_argument);
  }
}

TEST(RobustKernels, ScaleDeltaNeedsALossAndAThreshold) {
  EXPECT_THROW(ScaleDeltaLoss(nullptr, 1.0), std::invalid_argument);
  EXPECT_THROW(ScaleDeltaLoss(std::make_shared<TrivialLoss>(), 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
