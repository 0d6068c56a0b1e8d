// The solvers that never form the Schur complement; that they find the same steps as all others is in equality_test.cc.
#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/sparse/steps/implicit_schur.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

VecX RandomVector(int size) {
  Random random(9);
  VecX v(size);
  for (int i = 0; i < size; ++i) v[i] = random.Normal();
  return v;
}

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

const Scene& SceneNamed(const std::string& name) {
  for (const Scene& scene : AllScenes()) {
    if (scene.name == name) return scene;
  }
  throw std::logic_error("no scene " + name);
}

// S x by the operator against the Schur complement that another solver formed.
TEST(ImplicitSchur, MultipliesByTheSchurComplement) {
  for (const char* name : {"Bal", "Points", "Mono10x50Priors", "MixedDimensions"}) {
    SCOPED_TRACE(name);
    System formed(SceneNamed(name), ReducedSolverType::kDenseCholesky, {});
    formed.Step(1e-2);
    const MatXX S = formed.solver->SchurComplement();
    const VecX x = RandomVector(static_cast<int>(S.rows())), expected = S * x;
    const double bound = (S.cwiseAbs() * x.cwiseAbs()).norm();
    Eliminated eliminated = formed.solver->GetEliminated();
    ThreadPool pool(2);
    ImplicitSchur schur;
    schur.Prepare(formed.solver->GetStructure(), &pool);
    ASSERT_TRUE(schur.Damp(formed.solver->GetLinearized(), {1e-2, Damping::kDiagonal}, Preconditioner::kSchurJacobi,
                           &eliminated));
    VecX y(x.size());
    schur.Multiply(x, &y);
    // H_pl H_ll⁻¹ H_plᵀ may be larger than S, of which it takes away the most.
    EXPECT_LT((y - expected).norm(), 1e-11 * bound);
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
