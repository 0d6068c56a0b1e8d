// The constants of g2o's algorithms, on systems that follow a script; tests/solve/minimizer_test.cc has more of them.
#include <gtest/gtest.h>

#include "ch5_backend/solve/minimizer.h"
#include "ch5_backend/solve/step_strategy.h"
#include "tests/solve/scripted_system.h"

namespace ch5::test {
namespace {

// ---- G7: Levenberg-Marquardt -------------------------------------------------------------------------------------

TEST(G2o, G7_LambdaFollowsItsTrace) {
  // H = diag(1, 4), b = (2, 4), τ = 0.25: λ₀ = 1. Costs: a good step, two bad ones and a good one.
  ScriptedSystem system((MatXX(2, 2) << 1, 0, 0, 4).finished(), (VecX(2) << 2, 4).finished(), {10, 8, 9, 9, 7, 6});
  SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 3);
  options.tau = 0.25;
  const Summary summary = Minimize(&system, options);
  ASSERT_EQ(summary.trace.size(), 4u);
  // Δx = (2/2, 4/5), predicted bᵀΔx − ½ΔxᵀHΔx = 5.2 − ½ (1 + 2.56) = 3.42.
  EXPECT_DOUBLE_EQ(summary.trace[1].lambda, 1.0);
  EXPECT_NEAR(summary.trace[1].gain_ratio, 2.0 / 3.42, 1e-14);
  EXPECT_EQ(summary.trace[1].step_type, StepType::kDamped);
  const double t = 2.0 * summary.trace[1].gain_ratio - 1.0;
  const double after_success = std::max(1.0 / 3.0, std::min(2.0 / 3.0, 1.0 - t * t * t));
  EXPECT_NEAR(summary.trace[2].lambda, after_success * 2.0 * 4.0, 1e-14);  // two failures: ν = 2, then 4
  EXPECT_EQ(summary.trace[2].trials, 3);
}

TEST(G2o, G7_TenTrialsAndNoMore) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 11.0});
  const Summary summary = Minimize(&system, WithoutStopRules(Algorithm::kLevenbergMarquardt, 20));
  EXPECT_EQ(summary.cost_evaluations, 10);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_EQ(summary.termination, Termination::kNoDecrease);
}

// ---- G8: Dogleg --------------------------------------------------------------------------------------------------

// H = diag(1, 9), b = (3, 9):  Gauss-Newton's step (3, 1), ‖·‖ = √10; the Cauchy point is 1.157 long.
ScriptedSystem TwoUnknowns(std::vector<double> costs) {
  return {(MatXX(2, 2) << 1, 0, 0, 9).finished(), (VecX(2) << 3, 9).finished(), std::move(costs)};
}

TEST(G2o, G8_EachStepTellsItsType) {
  const auto type_at = [](double radius) {
    ScriptedSystem system = TwoUnknowns({10.0, 9.0});
    SolveOptions options = WithoutStopRules(Algorithm::kDogleg, 1);
    options.initial_radius = radius;
    return Minimize(&system, options).trace.back().step_type;
  };
  EXPECT_EQ(type_at(1.1), StepType::kSteepestDescent);
  EXPECT_EQ(type_at(1.2), StepType::kDogleg);
  EXPECT_EQ(type_at(3.1), StepType::kDogleg);
  EXPECT_EQ(type_at(3.2), StepType::kGaussNewton);
}

TEST(G2o, G8_TheRadiusGrowsToThreeStepsOrHalves) {
  // At Δ = 3.2 Gauss-Newton predicts ½bᵀH⁻¹b = 9. ρ = 8/9 > ¾: Δ = 3 √10; ρ = 4.5/9: as it is; ρ = 0.9/9 < ¼: Δ/2; ρ = 6.6/9;
  // a cost that rises: half the step's length.
  ScriptedSystem system = TwoUnknowns({100.0, 92.0, 87.5, 86.6, 80.0, 90.0, 79.0});
  SolveOptions options = WithoutStopRules(Algorithm::kDogleg, 5);
  options.initial_radius = 3.2;
  const Summary summary = Minimize(&system, options);
  ASSERT_EQ(summary.trace.size(), 6u);
  EXPECT_DOUBLE_EQ(summary.trace[1].lambda, 3.2);
  EXPECT_DOUBLE_EQ(summary.trace[2].lambda, 3.0 * std::sqrt(10.0));
  EXPECT_DOUBLE_EQ(summary.trace[3].lambda, 3.0 * std::sqrt(10.0));
  EXPECT_DOUBLE_EQ(summary.trace[4].lambda, 1.5 * std::sqrt(10.0));
  EXPECT_DOUBLE_EQ(summary.trace[5].lambda, 0.5 * std::sqrt(10.0));
  EXPECT_NEAR(summary.trace[1].gain_ratio, 8.0 / 9.0, 1e-14);
  EXPECT_EQ(summary.trace[4].step_type, StepType::kGaussNewton);
}

TEST(G2o, G8_ASingularHIsDampedByTenfoldUpToAThousand) {
  for (const double solvable_from : {1e-12, 2e-5, 900.0, 1e5}) {
    ScriptedSystem system = TwoUnknowns({10.0, 9.0});
    system.solvable_from_ = solvable_from;
    const auto strategy = MakeDogleg(1e4);
    strategy->Begin(&system);
    VecX step;
    ASSERT_EQ(strategy->Propose(&system, &step), solvable_from < 1e4);
    if (solvable_from > 1e4) continue;
    double lambda = 1e-12;
    while (lambda < solvable_from * (1.0 - 1e-9)) lambda *= 10.0;
    const VecX expected = (VecX(2) << 3.0 / (1.0 + lambda), 9.0 / (9.0 + lambda)).finished();
    EXPECT_LT((step - expected).norm(), 1e-12 * expected.norm()) << solvable_from;
  }
}

}  // namespace
}  // namespace ch5::test
