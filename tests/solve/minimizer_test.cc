// Gauss-Newton, Levenberg-Marquardt and Dogleg: numbers by hand, stop rules, and problems with known answers.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/solve/step_strategy.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/types/edge_curve_fitting.h"
#include "ch5_backend/world/simulate/mono_ba.h"
#include "ch5_backend/world/simulate/random.h"
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

TEST(LevenbergMarquardt, GainRatioIsActualOverPredictedDecrease) {
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

// ---- Stop rules --------------------------------------------------------------------------------------------------

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

// ---- Problems with known answers, in both rooms ------------------------------------------------------------------

class KnownAnswers : public testing::TestWithParam<std::tuple<Algorithm, bool>> {
 protected:
  Summary Solve(Graph* graph, SolveOptions options) {
    options.algorithm = std::get<0>(GetParam());
    return std::get<1>(GetParam()) ? SparseOptimizer(graph).Solve(options) : Problem(graph).Solve(options);
  }
};

// r = a·x − c, linear.
class LineEdge : public SizedEdge<1, VertexVector<3>> {
 public:
  LineEdge(std::shared_ptr<VertexVector<3>> x, const Vec3& a, double c) : SizedEdge(std::move(x)), a_(a), c_(c) {}
  void ComputeResidual() override { r_[0] = a_.dot(GetVertex<0>().GetEstimate()) - c_; }
  void ComputeJacobians() override { J<0>() = a_.transpose(); }
  std::string TypeInfo() const override { return "LineEdge"; }

 private:
  Vec3 a_;
  double c_;
};

TEST_P(KnownAnswers, ALinearProblemTakesOneStep) {
  Random random(4);
  Graph graph;
  auto x = std::make_shared<VertexVector<3>>(Vec3(5, -3, 8));
  graph.AddVertex(x);
  MatXX A(10, 3);
  VecX c(10);
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 3; ++k) A(i, k) = random.Normal();
    c[i] = random.Normal();
    graph.AddEdge(std::make_shared<LineEdge>(x, A.row(i).transpose(), c[i]));
  }
  SolveOptions options;
  options.max_iterations = 1;
  options.tau = 0.0;  // Levenberg-Marquardt without damping is Gauss-Newton
  Solve(&graph, options);
  const VecX expected = (A.transpose() * A).inverse() * (A.transpose() * c);
  EXPECT_LT((x->GetEstimate() - expected).norm(), 1e-12);
}

TEST_P(KnownAnswers, CurveFitting) {
  Random random(1);
  Graph graph;
  auto abc = std::make_shared<VertexVector<3>>(Vec3::Zero());
  graph.AddVertex(abc);
  for (int i = 0; i < 100; ++i) {
    const double x = i / 100.0;
    graph.AddEdge(std::make_shared<EdgeCurveFitting>(abc, x, std::exp((x + 2.0) * x + 1.0) + random.Normal()));
  }
  SolveOptions options;
  options.max_iterations = 50;
  options.cost_tolerance = 1e-12;
  const Summary summary = Solve(&graph, options);
  EXPECT_TRUE(IsConverged(summary.termination)) << summary.message;
  // 97 degrees of freedom of unit noise: ½χ² = 48.5 ± 7; the parameters' own σ are about 0.07, 0.1 and 0.04.
  EXPECT_NEAR(summary.final_cost, 48.5, 21.0);
  EXPECT_LT((abc->GetEstimate() - Vec3(1, 2, 1)).norm(), 0.4);
}

// Powell's singular function (Moré, Garbow, Hillstrom 1981, no. 13): the Jacobian loses rank at the solution 0.
class PowellEdge : public SizedEdge<4, VertexVector<4>> {
 public:
  explicit PowellEdge(std::shared_ptr<VertexVector<4>> x) : SizedEdge(std::move(x)) {}
  void ComputeResidual() override {
    const Eigen::Vector4d& x = GetVertex<0>().GetEstimate();
    const double u = x[1] - 2.0 * x[2], v = x[0] - x[3];
    r_ << x[0] + 10.0 * x[1], std::sqrt(5.0) * (x[2] - x[3]), u * u, std::sqrt(10.0) * v * v;
  }
  void ComputeJacobians() override {
    const Eigen::Vector4d& x = GetVertex<0>().GetEstimate();
    const double u = x[1] - 2.0 * x[2], v = 2.0 * std::sqrt(10.0) * (x[0] - x[3]), w = std::sqrt(5.0);
    J<0>() << 1, 10, 0, 0, 0, 0, w, -w, 0, 2 * u, -4 * u, 0, v, 0, 0, -v;
  }
  std::string TypeInfo() const override { return "PowellEdge"; }
};

TEST_P(KnownAnswers, PowellsSingularFunction) {
  Graph graph;
  auto x = std::make_shared<VertexVector<4>>(Eigen::Vector4d(3, -1, 0, 1));
  graph.AddVertex(x);
  graph.AddEdge(std::make_shared<PowellEdge>(x));
  SolveOptions options;
  options.max_iterations = 100;
  options.cost_tolerance = options.step_tolerance = 0.0;
  options.gradient_tolerance = 1e-20;
  const Summary summary = Solve(&graph, options);
  EXPECT_DOUBLE_EQ(summary.initial_cost, 107.5);
  EXPECT_LT(summary.final_cost, 1e-16) << summary.message;
  EXPECT_LT(x->GetEstimate().cwiseAbs().maxCoeff(), 1e-4);  // the cost is of fourth order in x
}

INSTANTIATE_TEST_SUITE_P(Algorithms, KnownAnswers,
                         testing::Combine(testing::Values(Algorithm::kGaussNewton, Algorithm::kLevenbergMarquardt,
                                                          Algorithm::kDogleg),
                                          testing::Bool()));

}  // namespace
}  // namespace ch5::test
