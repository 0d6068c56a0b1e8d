// Levenberg-Marquardt and Dogleg: how λ and the radius follow the gain, with numbers by hand.
#include "ch5_backend/solve/step_strategy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "tests/solve/scripted_system.h"

namespace ch5::test {
namespace {

// ---- Levenberg-Marquardt -----------------------------------------------------------------------------------------

TEST(LevenbergMarquardt, DampingFollowsNielsen) {
  ScriptedSystem system = OneUnknown(400.0, 1.0, {1.0});
  const auto strategy = MakeLevenbergMarquardt(1e-3);
  strategy->Begin(&system);
  EXPECT_DOUBLE_EQ(strategy->Parameter(), 0.4);  // τ max diag H
  strategy->Accepted(0.5);                       // 1 − (2ρ − 1)³ = 1, at most 2/3
  EXPECT_DOUBLE_EQ(strategy->Parameter(), 0.4 * 2 / 3);
  strategy->Accepted(0.9);  // 1 − 0.8³ = 0.488
  EXPECT_NEAR(strategy->Parameter(), 0.4 * 2 / 3 * 0.488, 1e-15);
  strategy->Accepted(1.0);  // 1 − 1 = 0, at least 1/3
  const double lambda = 0.4 * 2 / 3 * 0.488 / 3;
  EXPECT_NEAR(strategy->Parameter(), lambda, 1e-15);
  EXPECT_TRUE(strategy->Rejected());  // ν = 2, 4, 8
  EXPECT_TRUE(strategy->Rejected());
  EXPECT_TRUE(strategy->Rejected());
  EXPECT_NEAR(strategy->Parameter(), 64 * lambda, 1e-14);
  strategy->Begin(&system);  // the next Hessian keeps λ
  EXPECT_NEAR(strategy->Parameter(), 64 * lambda, 1e-14);
  strategy->Accepted(1.0);  // and success puts ν back to 2
  EXPECT_TRUE(strategy->Rejected());
  EXPECT_NEAR(strategy->Parameter(), 64 * lambda / 3 * 2, 1e-14);
}

TEST(LevenbergMarquardt, DiagonalDampingBeginsAtTau) {
  ScriptedSystem system = OneUnknown(400.0, 1.0, {1.0});
  system.SetDamping(Damping::kDiagonal);
  const auto strategy = MakeLevenbergMarquardt(1e-3);
  strategy->Begin(&system);
  EXPECT_DOUBLE_EQ(strategy->Parameter(), 1e-3);
}

TEST(LevenbergMarquardt, GainRatioIsActualOverModelCostChange) {
  // λ₀ = 2:  Δx = 6/(4 + 2) = 1, predicted 6·1 − ½·4·1² = 4, actual 10 − 8.  Then λ = 4/3, rejected, 8/3 is taken:
  // Δx = 6/(20/3) = 0.9, predicted 5.4 − 1.62 = 3.78, actual 8 − 5.
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0, 9.0, 5.0});
  SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 2);
  options.tau = 0.5;
  const Summary summary = Minimize(&system, options);
  ASSERT_EQ(summary.trace.size(), 3u);
  EXPECT_DOUBLE_EQ(summary.trace[1].lambda, 2.0);
  EXPECT_DOUBLE_EQ(summary.trace[1].gain_ratio, 0.5);
  EXPECT_EQ(summary.trace[1].trials, 1);
  EXPECT_DOUBLE_EQ(summary.trace[2].lambda, 8.0 / 3.0);
  EXPECT_NEAR(summary.trace[2].gain_ratio, 3.0 / 3.78, 1e-14);
  EXPECT_EQ(summary.trace[2].trials, 2);
  EXPECT_EQ(summary.cost_evaluations, 3);
  EXPECT_EQ(summary.final_cost, 5.0);
  EXPECT_EQ(system.hessians_, 2) << "one for each accepted step, none for the rejected and none at the end";
}

// ---- Dogleg ------------------------------------------------------------------------------------------------------

// H = diag(1, 9), b = (3, 9):  Gauss-Newton (3, 1), ‖·‖ = √10;  along the gradient bᵀb/bᵀHb = 90/738 of b.
class DoglegSteps : public testing::Test {
 protected:
  VecX Step(double radius) {
    const auto strategy = MakeDogleg(radius);
    strategy->Begin(&system_);
    VecX step;
    EXPECT_TRUE(strategy->Propose(&system_, &step));
    EXPECT_LE(step.norm(), radius * (1.0 + 4.0 * std::numeric_limits<double>::epsilon()));
    return step;
  }
  const VecX b_ = (VecX(2) << 3, 9).finished();
  const VecX cauchy_ = 90.0 / 738.0 * b_;
  const VecX newton_ = (VecX(2) << 3, 1).finished();
  ScriptedSystem system_{(MatXX(2, 2) << 1, 0, 0, 9).finished(), b_, {1.0}};
};

TEST_F(DoglegSteps, InsideTheRadiusIsGaussNewtons) { EXPECT_LT((Step(4.0) - newton_).norm(), 1e-14); }

TEST_F(DoglegSteps, AtASmallRadiusFollowsTheGradient) { EXPECT_LT((Step(0.5) - 0.5 * b_.normalized()).norm(), 1e-15); }

TEST_F(DoglegSteps, BetweenBendsFromCauchyToNewton) {
  for (const double radius : {1.2, 2.0, 3.0}) {
    const VecX step = Step(radius);
    EXPECT_NEAR(step.norm(), radius, 1e-14);
    const VecX d = newton_ - cauchy_;
    const double beta = (step - cauchy_).dot(d) / d.squaredNorm();
    EXPECT_GT(beta, 0.0);
    EXPECT_LT(beta, 1.0);
    EXPECT_LT((cauchy_ + beta * d - step).norm(), 1e-14);
  }
}

TEST_F(DoglegSteps, RadiusFollowsTheGain) {
  const auto strategy = MakeDogleg(2.0);
  strategy->Begin(&system_);
  VecX step;
  strategy->Propose(&system_, &step);  // of length 2
  strategy->Accepted(0.5);
  EXPECT_EQ(strategy->Parameter(), 2.0);
  strategy->Accepted(0.8);
  EXPECT_DOUBLE_EQ(strategy->Parameter(), 6.0);  // 3‖h‖
  strategy->Accepted(0.1);
  EXPECT_DOUBLE_EQ(strategy->Parameter(), 3.0);
  strategy->Propose(&system_, &step);
  EXPECT_TRUE(strategy->Rejected());
  EXPECT_DOUBLE_EQ(strategy->Parameter(), 1.5);
}

TEST_F(DoglegSteps, ASingularHessianIsDampedJustEnough) {
  system_.solvable_from_ = 0.9e-9;  // the ladder of damping climbs by tens
  EXPECT_LT((Step(4.0) - newton_).norm(), 1e-8);
}

TEST(Dogleg, StaysInsideItsRadiusInAWholeRun) {
  MonoBaOptions scene_options;
  scene_options.frames = 5;
  scene_options.points = 40;
  scene_options.position_sigma = 0.1;
  scene_options.rotation_sigma = 0.05;
  MonoBa scene;
  BuildMonoBa(SimulateMonoBa(scene_options), Gauge::kFixTwoFrames, 1e6, 0.0, &scene);
  SolveOptions options;
  options.algorithm = Algorithm::kDogleg;
  options.initial_radius = 0.05;  // so that all kinds of steps occur
  options.max_iterations = 50;
  const Summary summary = Problem(&scene.graph).Solve(options);
  EXPECT_TRUE(IsConverged(summary.termination)) << summary.message;
  for (size_t k = 1; k < summary.trace.size(); ++k) {
    const IterationInfo& info = summary.trace[k];
    EXPECT_LE(info.step_norm, info.lambda * (1.0 + 4.0 * std::numeric_limits<double>::epsilon())) << k;
  }
}

}  // namespace
}  // namespace ch5::test
