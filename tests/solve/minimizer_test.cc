// The rules that end Minimize; Levenberg-Marquardt and Dogleg: how λ follows the gain and where a step ends, with numbers by hand.
#include "ch5_backend/solve/minimizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "ch5_backend/solve/step_strategy.h"
#include "tests/solve/scripted_system.h"

namespace ch5::test {
namespace {

void ExpectStop(const Summary& summary, Termination expected, bool converged) {
  EXPECT_EQ(summary.termination, expected) << summary.message;
  EXPECT_EQ(IsConverged(summary.termination), converged);
  EXPECT_EQ(summary.message.rfind(ToString(expected) + ": ", 0), 0u) << summary.message;
}

// A run of H = 4 and this b, whose costs are those of the start and of each trial: 20 iterations of Levenberg-Marquardt at
// most, without stop rules but for what `set` changes.
void ExpectEnd(const char* rule, double b, std::vector<double> costs, Termination expected, int iterations,
               double final_cost, const std::function<void(SolveOptions*)>& set = nullptr) {
  SCOPED_TRACE(rule);
  ScriptedSystem system = OneUnknown(4.0, b, std::move(costs));
  SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 20);
  if (set) set(&options);
  const Summary summary = Minimize(&system, options);
  const bool is_converged = expected == Termination::kCostConverged || expected == Termination::kStepConverged ||
                            expected == Termination::kGradientConverged;
  ExpectStop(summary, expected, is_converged);
  EXPECT_EQ(summary.iterations, iterations);
  EXPECT_EQ(summary.final_cost, final_cost);
}

TEST(StopRules, EachEndsTheRunWhereItShould) {
  ExpectEnd("cost tolerance", 6.0, {10, 8, 7, 6.999}, Termination::kCostConverged, 3, 6.999,
            [](auto* o) { o->cost_tolerance = 1e-3; });
  ExpectEnd("a decrease below the rounding of the cost", 1e-8, {10.0, 10.0 - 4e-15, 10.0 - 8e-15},
            Termination::kCostConverged, 1, 10.0 - 4e-15);
  ExpectEnd("gradient tolerance", 6.0, {1e7, 8}, Termination::kGradientConverged, 0, 1e7,
            [](auto* o) { o->gradient_tolerance = 1.0; });
  ExpectEnd("a gradient that promises 36/8 of a cost of 10", 6.0, {10, 8}, Termination::kMaxIterations, 1, 8,
            [](auto* o) { o->gradient_tolerance = 1.0, o->max_iterations = 1; });
  // The gradient promises 36/8.
  const auto small_step = [](auto* o) { o->algorithm = Algorithm::kGaussNewton, o->step_tolerance = 1.5; };
  ExpectEnd("a step of 6/4, and ‖x‖ counts as 1", 6.0, {1e7, 8e6}, Termination::kStepConverged, 1, 8e6, small_step);
  ExpectEnd("a small step, and the gradient promises half of the cost", 6.0, {10, 9, 8}, Termination::kMaxIterations, 2,
            8, [&](auto* o) { small_step(o), o->max_iterations = 2; });
  const auto invisible_step = [](auto* o) { o->step_tolerance = 0.5; };
  ExpectEnd("a step that is not visible in the states", 6.0, {1e7, 1e7 + 0.1}, Termination::kStepConverged, 1, 1e7,
            invisible_step);
  ExpectEnd("the same, and the gradient promises half of the cost", 6.0, {10, 10.1}, Termination::kNoDecrease, 1, 10,
            invisible_step);
  const auto heavy_damping = [](auto* o) { o->tau = 1e12, o->cost_tolerance = 1e-6, o->max_iterations = 3; };
  ExpectEnd("damping that holds each step back", 6.0, {10, 10 - 9e-12, 9, 8}, Termination::kMaxIterations, 3, 8,
            heavy_damping);
  ExpectEnd("a small step up where it should be down", 6.0, {10, 13}, Termination::kNoDecrease, 1, 10,
            [](auto* o) { o->step_tolerance = 0.5; });
  ExpectEnd("a step that moves nothing", 6.0, {10, 10}, Termination::kNoDecrease, 1, 10);
  ExpectEnd("the same after a good step", 6.0, {10, 8, 8, 7}, Termination::kNoDecrease, 2, 8);
  ExpectEnd("the same of a method that takes every step", 6.0, {10, 10}, Termination::kNoDecrease, 1, 10,
            [](auto* o) { o->algorithm = Algorithm::kGaussNewton; });
  ExpectEnd("a small step to no number", 6.0, {10, NAN}, Termination::kNoDecrease, 1, 10,
            [](auto* o) { o->step_tolerance = 0.5; });
  ExpectEnd("iterations", 6.0, {10, 8, 6, 4, 2}, Termination::kMaxIterations, 3, 4,
            [](auto* o) { o->max_iterations = 3; });
  ExpectEnd("no iteration", 6.0, {10, 8}, Termination::kMaxIterations, 0, 10, [](auto* o) { o->max_iterations = 0; });
  ExpectEnd("trials", 6.0, {10, 11, 11, 11, 11, 8}, Termination::kNoDecrease, 1, 10,
            [](auto* o) { o->max_trials = 4; });
  ExpectEnd("a gradient of NaN", NAN, {1}, Termination::kNotFinite, 0, 1);
  ExpectEnd("a minimum at the start", 0.0, {1}, Termination::kGradientConverged, 0, 1);
  ExpectEnd("costs that are not finite are no decrease", 6.0, {10, INFINITY, NAN, 8, 8}, Termination::kMaxIterations, 1,
            8, [](auto* o) { o->max_iterations = 1; });
  ScriptedSystem weightless = OneUnknown(0.0, 0.0, {1});
  ExpectStop(Minimize(&weightless), Termination::kNothingToOptimize, false);
  for (int i = 0; i < 9; ++i) {  // wherever among others
    VecX b = VecX::Constant(9, 6.0);
    b[i] = NAN;
    ScriptedSystem no_number(MatXX::Identity(9, 9), b, {10, 8});
    ExpectStop(Minimize(&no_number), Termination::kNotFinite, false);
  }
  ScriptedSystem bad_cost = OneUnknown(4.0, 6.0, {NAN});
  ExpectStop(Minimize(&bad_cost), Termination::kNotFinite, false);
}

// Where a tenth of the step lowers the cost, the Jacobians are right.
TEST(StopRules, AStepThatIsShortOnlyBesideAFewHugeStatesBlamesNoJacobian) {
  for (const double shorter : {9.0, 13.0}) {
    ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 13.0, shorter});
    SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 20);
    options.step_tolerance = 1.0;  // ‖x‖ counts as 1, a step of 1.5 as short
    const std::string message = Minimize(&system, options).message;
    EXPECT_EQ(message.find("far larger than the others") != std::string::npos, shorter < 10.0) << message;
    EXPECT_EQ(message.find("CheckJacobians") != std::string::npos, shorter > 10.0) << message;
  }
}

// A point just before a camera costs 1e25 px² or 1e30: beside that 10 is nothing, but a promise of 36/8 is nearly half of it.
TEST(StopRules, AStartFarAwayDoesNotPassForAMinimum) {
  for (const double first : {1e25, 1e30}) {
    ScriptedSystem system = OneUnknown(4.0, 6e12, {first, 10.0, 8.0});
    system.later_b_ = 1e-12;
    SolveOptions options;
    options.algorithm = Algorithm::kLevenbergMarquardt;
    options.max_iterations = 2;
    const Summary summary = Minimize(&system, options);
    ExpectStop(summary, Termination::kMaxIterations, false);
    EXPECT_EQ(summary.final_cost, 8.0);
  }
}

// Each direction alone promises 0.001²/8, far below 10, but the last step has gained 2: there is more along the valley.
TEST(StopRules, AValleyAlongWhichTheCostStillFallsIsNoMinimum) {
  for (const double cost : {12.0, 10.0005}) {
    ScriptedSystem system = OneUnknown(4.0, 6e12, {cost, 10.0, 8.0});
    system.later_b_ = 0.001 / 6e12;
    SolveOptions options;
    options.algorithm = Algorithm::kLevenbergMarquardt;
    options.max_iterations = 2;
    options.cost_tolerance = options.step_tolerance = 0.0;
    ExpectStop(Minimize(&system, options), cost > 11.0 ? Termination::kMaxIterations : Termination::kGradientConverged,
               cost < 11.0);
  }
}

// 3 · 1e-8 / 4 is a step that does not count, however little it would leave of a cost that is nothing but rounding.
TEST(StopRules, NearAPerfectFitTheStepDecides) {
  ScriptedSystem system = OneUnknown(4.0, 600.0, {1e4, 1e-16});
  system.later_b_ = 5e-11;
  SolveOptions options;
  options.algorithm = Algorithm::kLevenbergMarquardt;
  const Summary summary = Minimize(&system, options);
  ExpectStop(summary, Termination::kGradientConverged, true);
  EXPECT_EQ(summary.iterations, 1);
}

TEST(StopRules, LinearSolverFailed) {
  for (const Algorithm algorithm : {Algorithm::kGaussNewton, Algorithm::kLevenbergMarquardt, Algorithm::kDogleg}) {
    ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0});
    system.solvable_from_ = 1e300;
    const Summary summary = Minimize(&system, WithoutStopRules(algorithm, 20));
    ExpectStop(summary, Termination::kLinearSolverFailed, false);
    EXPECT_NE(summary.message.find("is a gauge free"), std::string::npos) << summary.message;
    ScriptedSystem apart(Vec2(1e40, 1.0).asDiagonal(), Vec2(6.0, 6.0), {10.0, 8.0});
    apart.solvable_from_ = 1e300;
    const std::string message = Minimize(&apart, WithoutStopRules(algorithm, 20)).message;
    EXPECT_NE(message.find("goes from 1 to 1e+40: does a point lie in the plane"), std::string::npos) << message;
  }
}

// A loss that is negative, which would otherwise be a cost that falls for ever.
TEST(StopRules, NegativeCost) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {-1.0, -2.0});
  ExpectStop(Minimize(&system), Termination::kNotFinite, false);
}

TEST(StopRules, ACallbackThatMovesAVertexEndsTheRun) {
  ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0, 1e9});
  SolveOptions options = WithoutStopRules(Algorithm::kLevenbergMarquardt, 20);
  options.callback = [&](const IterationInfo& info) {
    if (info.iteration == 1) system.state_norm_ = 1e5;
    return true;
  };
  const Summary summary = Minimize(&system, options);
  ExpectStop(summary, Termination::kUserStopped, false);
  EXPECT_EQ(summary.final_cost, 1e9) << "that of the states that it has left";
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
    const IterationInfo& start = summaries[0].trace[0];
    EXPECT_TRUE(std::isnan(start.lambda) && std::isnan(start.gain_ratio) && std::isnan(start.step_norm));
    for (size_t k = 1; k < summaries[0].trace.size(); ++k) {
      EXPECT_EQ(summaries[0].trace[k].cost, summaries[1].trace[k].cost);
      EXPECT_EQ(summaries[0].trace[k].step_norm, summaries[1].trace[k].step_norm);
      EXPECT_EQ(summaries[0].trace[k].lambda, summaries[1].trace[k].lambda);
    }
  }
}

// By hand: the model promises 6²/(2 · 4) = 4.5, and what the landmarks gain alone is none of it. A gain of 0.001 of a cost of
// 6 is too little to go on.
TEST(LandmarkSteps, AreNoPartOfTheGainRatioAndEndOnceTheyGainTooLittle) {
  for (const int steps : {0, 1}) {
    ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 6.0, 4.0, 3.0});
    system.refined_ = {2.0, 0.001};
    SolveOptions options = WithoutStopRules(Algorithm::kGaussNewton, 3);
    options.landmark_steps = steps;
    const Summary summary = Minimize(&system, options);
    EXPECT_NEAR(summary.trace[1].gain_ratio, (10.0 - 6.0 - 2.0 * steps) / 4.5, 1e-15);
    EXPECT_EQ(system.refinements_, 2 * steps);
  }
}

// A step from 10 to 12 is kept where the landmarks alone gain enough to end below 10, and only if it is damped.
TEST(LandmarkSteps, RescueADampedStep) {
  struct Row {
    const char* what;
    Algorithm algorithm;
    int steps;
    double gain;
    int trials;
  };
  for (const Row& row : {Row{"enough", Algorithm::kLevenbergMarquardt, 2, 3.0, 1},
                         Row{"too little", Algorithm::kLevenbergMarquardt, 2, 1.0, 2},
                         Row{"not asked for", Algorithm::kLevenbergMarquardt, 0, 3.0, 2},
                         Row{"not damped", Algorithm::kDogleg, 2, 3.0, 2}}) {
    ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 12.0, 9.0});
    system.refined_ = {row.gain};
    SolveOptions options = WithoutStopRules(row.algorithm, 1);
    options.rescue_steps = row.steps;
    const Summary summary = Minimize(&system, options);
    EXPECT_EQ(summary.trace[1].trials, row.trials) << row.what;
    EXPECT_EQ(summary.final_cost, 9.0) << row.what;
    EXPECT_LE(row.trials == 1 ? summary.trace[1].gain_ratio : 0.5, 0.5)
        << "what the landmarks gained is not the model's";
  }
}

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

// Dogleg begins with Gauss and Newton's step, 6/4, and damping would make it shorter.
TEST(Algorithm, AutomaticIsTheOneThatSuitsTheSystem) {
  for (const bool suits_dogleg : {false, true}) {
    ScriptedSystem system = OneUnknown(4.0, 6.0, {10.0, 8.0});
    system.suits_dogleg_ = suits_dogleg;
    const Summary summary = Minimize(&system, WithoutStopRules(Algorithm::kAutomatic, 1));
    EXPECT_EQ(summary.trace[1].step_type, suits_dogleg ? StepType::kGaussNewton : StepType::kDamped);
  }
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

TEST_F(DoglegSteps, AtASmallRadiusFollowsTheGradientOfNow) {
  const auto strategy = MakeDogleg(0.5);
  ScriptedSystem next({(MatXX(2, 2) << 1, 0, 0, 9).finished(), Vec2(4, -2), {1.0}});
  for (ScriptedSystem* system : {&system_, &next}) {
    strategy->Begin(system);
    VecX step;
    ASSERT_TRUE(strategy->Propose(system, &step));
    EXPECT_LT((step - 0.5 * system->RightHandSide().normalized()).norm(), 1e-15);
  }
}

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

}  // namespace
}  // namespace ch5::test
