// The rules that end Minimize.
#include "ch5_backend/solve/minimizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/solve/scripted_system.h"

namespace ch5::test {
namespace {

void ExpectStop(const Summary& summary, Termination expected, bool converged) {
  EXPECT_EQ(summary.termination, expected) << summary.message;
  EXPECT_EQ(IsConverged(summary.termination), converged);
  EXPECT_EQ(summary.message.rfind(ToString(expected) + ": ", 0), 0u) << summary.message;
}

TEST(StopRules, CostConverged) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0, 7.0, 6.999});
  SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 20);
  options.cost_tolerance = 1e-3;
  const Summary summary = Minimize(&system, options);
  ExpectStop(summary, Termination::kCostConverged, true);
  EXPECT_EQ(summary.iterations, 3);
  EXPECT_EQ(summary.trace.back().cost, 6.999);
}

TEST(StopRules, ADecreaseBelowTheRoundingOfTheCostEndsTheRun) {
  ScriptedSystem system = OneUnknown(4.0, 1e-8, {10.0, 10.0 - 4e-15, 10.0 - 8e-15});
  const Summary summary = Minimize(&system, WithoutStopRules(Algorithm::kLevenbergMarquardt, 20));
  ExpectStop(summary, Termination::kCostConverged, true);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_EQ(summary.final_cost, 10.0 - 4e-15);
}

TEST(StopRules, GradientConverged) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0});
  SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 20);
  options.gradient_tolerance = 1.0;  // the script's gradient never falls
  const Summary summary = Minimize(&system, options);
  ExpectStop(summary, Termination::kGradientConverged, true);
  EXPECT_EQ(summary.iterations, 0);
}

TEST(StopRules, StepConverged) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0});
  SolveOptions options = WithoutStopRules(Algorithm::kGaussNewton, 20);
  options.step_tolerance = 1.5;  // the step is 6/4 and ‖x‖ counts as 1
  ExpectStop(Minimize(&system, options), Termination::kStepConverged, true);
}

TEST(StopRules, AStepThatIsNoLongerVisibleInTheStatesEndsTheRun) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 11.0});
  SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 20);
  options.step_tolerance = 0.5;
  ExpectStop(Minimize(&system, options), Termination::kStepConverged, true);
}

TEST(StopRules, MaxIterations) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0, 6.0, 4.0, 2.0});
  const Summary summary = Minimize(&system, WithoutStopRules(Algorithm::kLevenbergMarquardt, 3));
  ExpectStop(summary, Termination::kMaxIterations, false);
  EXPECT_EQ(summary.iterations, 3);
  EXPECT_EQ(summary.trace.size(), 4u);
  EXPECT_EQ(summary.final_cost, 4.0);
}

TEST(StopRules, NoIterationsAllowed) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0});
  const Summary summary = Minimize(&system, WithoutStopRules(Algorithm::kLevenbergMarquardt, 0));
  ExpectStop(summary, Termination::kMaxIterations, false);
  EXPECT_EQ(summary.final_cost, 10.0);
}

TEST(StopRules, NoDecrease) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 11.0});
  SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 20);
  options.max_trials = 4;
  const Summary summary = Minimize(&system, options);
  ExpectStop(summary, Termination::kNoDecrease, false);
  EXPECT_EQ(summary.cost_evaluations, 4);
  EXPECT_EQ(summary.final_cost, 10.0);
}

TEST(StopRules, LinearSolverFailed) {
  for (const Algorithm algorithm : {Algorithm::kGaussNewton, Algorithm::kLevenbergMarquardt, Algorithm::kDogleg}) {
    ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0});
    system.solvable_from_ = 1e300;
    ExpectStop(Minimize(&system, WithoutStopRules(algorithm, 20)), Termination::kLinearSolverFailed, false);
  }
}

TEST(StopRules, NotFinite) {
  ScriptedSystem bad_cost = OneUnknown(4.0, 6.0, {NAN});
  ExpectStop(Minimize(&bad_cost), Termination::kNotFinite, false);
  ScriptedSystem bad_gradient = OneUnknown(4.0, NAN, {1.0});
  ExpectStop(Minimize(&bad_gradient), Termination::kNotFinite, false);
}

TEST(StopRules, AStepToAnInfiniteCostIsRejected) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, INFINITY, NAN, 8.0, 8.0});
  const Summary summary = Minimize(&system, WithoutStopRules(Algorithm::kLevenbergMarquardt, 1));
  EXPECT_EQ(summary.final_cost, 8.0);
  EXPECT_EQ(summary.cost_evaluations, 3);
}

TEST(StopRules, TheCallbackStopsAtOnce) {
  for (const int last : {0, 2}) {
    ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0, 6.0, 4.0, 2.0});
    SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 20);
    int calls = 0;
    options.callback = [&](const IterationInfo& info) {
      EXPECT_EQ(info.iteration, calls++);
      return info.iteration < last;
    };
    const Summary summary = Minimize(&system, options);
    ExpectStop(summary, Termination::kUserStopped, false);
    EXPECT_EQ(summary.iterations, last);
    EXPECT_EQ(calls, last + 1);
    EXPECT_EQ(summary.final_cost, 10.0 - 2.0 * last);
  }
}

// Costs that fall, then rise twice, then fall; the Hessian of a rejected trial must not be solved with.
TEST(OnePass, SavesTheCostsAndLeadsToTheSameSteps) {
  for (const Algorithm algorithm : {Algorithm::kGaussNewton, Algorithm::kLevenbergMarquardt, Algorithm::kDogleg}) {
    Summary summaries[2];
    for (const bool one_pass : {false, true}) {
      ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 6.0, 3.0, 8.0, 9.0, 1.0, 0.5, 0.4});
      system.one_pass_ = one_pass;
      summaries[one_pass] = Minimize(&system, WithoutStopRules(algorithm, 4));
      EXPECT_EQ(system.solves_with_old_hessian_, 0);
      const int rejected = summaries[one_pass].cost_evaluations - summaries[one_pass].iterations;
      EXPECT_EQ(rejected, algorithm == Algorithm::kGaussNewton ? 0 : 2);
      EXPECT_EQ(system.hessians_, one_pass && rejected > 0 ? 6 : 4);  // one too early, and the one before it again
    }
    ASSERT_EQ(summaries[0].trace.size(), summaries[1].trace.size());
    for (size_t k = 0; k < summaries[0].trace.size(); ++k) {
      EXPECT_EQ(summaries[0].trace[k].cost, summaries[1].trace[k].cost);
      EXPECT_EQ(summaries[0].trace[k].step_norm, summaries[1].trace[k].step_norm);
      EXPECT_EQ(summaries[0].trace[k].lambda, summaries[1].trace[k].lambda);
    }
  }
}

}  // namespace
}  // namespace ch5::test
