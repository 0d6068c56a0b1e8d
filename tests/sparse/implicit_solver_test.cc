// The solvers that never form the Schur complement; that they find the same steps as all others is in equality_test.cc.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

// A scene at its first linearization.
struct System {
  Graph graph;
  std::unique_ptr<SparseOptimizer> optimizer;
  SparseSolver* solver;

  System(const Scene& scene, ReducedSolverType type, const IterativeOptions& options, int threads = 1) {
    scene.build(&graph);
    optimizer = std::make_unique<SparseOptimizer>(&graph, threads);
    optimizer->SetReducedSolver(type, options);
    optimizer->SetDamping(Damping::kDiagonal);
    solver = &optimizer->GetSolver();
    solver->MakeHessian();
  }
  VecX Step(double lambda) {
    VecX step;
    EXPECT_TRUE(solver->SolveLinearSystem(lambda, &step));
    return step;
  }
};

class ImplicitSolvers : public testing::TestWithParam<Scene> {};

TEST_P(ImplicitSolvers, DoNotDependOnTheNumberOfThreads) {
  for (const auto type : {ReducedSolverType::kImplicitPcg, ReducedSolverType::kPowerSeries}) {
    const VecX one = System(GetParam(), type, {}, 1).Step(1e-3);
    EXPECT_EQ(System(GetParam(), type, {}, 3).Step(1e-3), one);
  }
}

TEST_P(ImplicitSolvers, EachPreconditionerLeadsToTheSameStep) {
  const VecX expected = System(GetParam(), ReducedSolverType::kDenseCholesky, {}).Step(1e-2);
  IterativeOptions options = IterativeOptions::Exact();
  for (const auto preconditioner : {Preconditioner::kBlockJacobi, Preconditioner::kSchurJacobi}) {
    options.preconditioner = preconditioner;
    const VecX step = System(GetParam(), ReducedSolverType::kImplicitPcg, options).Step(1e-2);
    EXPECT_LT((step - expected).norm(), 1e-6 * expected.norm());
  }
}

// The model's decrease is what an inexact step must have nearly all of; its distance from the exact one may be large.
TEST_P(ImplicitSolvers, AnInexactStepHasMostOfTheDecrease) {
  System exact(GetParam(), ReducedSolverType::kDenseCholesky, {});
  const double best = exact.solver->ModelCostChange(exact.Step(1e-2));
  for (const auto type : {ReducedSolverType::kImplicitPcg, ReducedSolverType::kPowerSeries}) {
    System inexact(GetParam(), type, {});
    const double decrease = inexact.solver->ModelCostChange(inexact.Step(1e-2));
    EXPECT_GT(decrease, 0.5 * best);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, ImplicitSolvers, testing::ValuesIn(AllScenes()),
                         [](const testing::TestParamInfo<Scene>& info) { return info.param.name; });

// An inexact solver keeps the Jacobians of H_pl in single precision. The rest of H is summed from the same, so that it
// stays positive semi-definite to double precision; b is exact.
TEST(SlotFactors, LeaveHPositiveAndTheGradientExact) {
  System exact(SceneNamed("Bal"), ReducedSolverType::kPowerSeries, IterativeOptions::Exact());
  System inexact(SceneNamed("Bal"), ReducedSolverType::kPowerSeries, {});
  EXPECT_TRUE(exact.solver->GetLinearized().H_pl_factors.empty());
  EXPECT_TRUE(inexact.solver->GetLinearized().H_pl.empty());
  const VecX b = exact.solver->RightHandSide();
  EXPECT_LT((inexact.solver->RightHandSide() - b).norm(), 1e-14 * b.norm());

  const MatXX H = inexact.solver->DenseHessian(), H_exact = exact.solver->DenseHessian();
  const VecX d = H_exact.diagonal().cwiseSqrt().cwiseInverse();
  const MatXX scaled = d.asDiagonal() * H * d.asDiagonal();
  EXPECT_LT((scaled - MatXX(d.asDiagonal() * H_exact * d.asDiagonal())).cwiseAbs().maxCoeff(), 3e-7);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatXX>(scaled).eigenvalues()[0], -1e-13 * static_cast<double>(H.rows()));

  Random random(9);
  const VecX v = VecX::NullaryExpr(H.rows(), [&] { return random.Normal(); });
  const VecX product = inexact.solver->MultiplyHessian(v);
  EXPECT_LT((product - H * v).norm(), 1e-12 * H.norm() * v.norm());
}

// Every product that the step takes is one with that H.
TEST(SlotFactors, SolveTheSystemThatTheyStandFor) {
  for (const auto preconditioner : {Preconditioner::kBlockJacobi, Preconditioner::kSchurJacobi}) {
    const IterativeOptions options{1e-6, 0.0, 10000, 0, preconditioner};
    System system(SceneNamed("Bal"), ReducedSolverType::kImplicitPcg, options);
    const VecX step = system.Step(1e-2), b = system.solver->RightHandSide();
    ASSERT_TRUE(system.solver->GetLinearized().H_pl.empty());
    MatXX H = system.solver->DenseHessian();
    H.diagonal() *= 1.01;
    const VecX expected = H.ldlt().solve(b);
    EXPECT_LT((step - expected).norm(), 1e-3 * expected.norm());
    EXPECT_NEAR(b.dot(step) - 0.5 * step.dot(H * step), b.dot(expected) / 2, 1e-8 * b.dot(expected));
  }
}

TEST(PowerSeries, SumsAsManyTermsAsTheAccuracyNeeds) {
  const Scene& scene = SceneNamed("Bal");
  const VecX expected = System(scene, ReducedSolverType::kDenseCholesky, {}).Step(1.0);
  int terms_before = 0;
  for (const double tolerance : {1e-2, 1e-4, 1e-8}) {
    IterativeOptions options = IterativeOptions::Exact();
    options.tolerance = tolerance;
    options.max_terms = options.max_iterations;
    System system(scene, ReducedSolverType::kPowerSeries, options);
    const VecX step = system.Step(1.0);
    const double error = (step - expected).norm() / expected.norm();
    EXPECT_LT(error, 10.0 * tolerance);
    EXPECT_GT(system.solver->ReducedProducts(), terms_before);
    terms_before = system.solver->ReducedProducts();
  }
}

TEST(PowerSeries, ConjugateGradientsGoOnFromItsSum) {
  const Scene& scene = SceneNamed("Bal");  // its gauge is free: without damping the series hardly converges
  const VecX expected = System(scene, ReducedSolverType::kDenseCholesky, {}).Step(1e-5);
  IterativeOptions options = IterativeOptions::Exact();
  options.max_terms = 20;
  System system(scene, ReducedSolverType::kPowerSeries, options);
  EXPECT_LT((system.Step(1e-5) - expected).norm(), 1e-6 * expected.norm());
  EXPECT_GT(system.solver->ReducedProducts(), 20);
}

}  // namespace
}  // namespace ch5::test
