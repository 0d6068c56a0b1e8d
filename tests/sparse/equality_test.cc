// All solvers on the same scenes: the dense one is the oracle.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "ch5_backend/dense/blocks/plain_block_solver.h"
#include "ch5_backend/dense/problem.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

double RelativeError(const MatXX& actual, const MatXX& expected) {
  if (actual.rows() != expected.rows() || actual.cols() != expected.cols()) return INFINITY;
  return expected.size() == 0 ? 0.0 : (actual - expected).norm() / std::max(expected.norm(), 1e-300);
}

// All systems of one scene, each with its own copy of the graph. The first is the oracle.
class AllSolvers : public testing::TestWithParam<Scene> {
 protected:
  struct Candidate {
    std::string name;
    std::unique_ptr<Graph> graph = std::make_unique<Graph>();
    std::unique_ptr<SparseOptimizer> optimizer;  // owner of `system` where it is the optimizer's choice
    std::unique_ptr<NormalEquations> own;
    NormalEquations* system = nullptr;
    SparseSolver* block = nullptr;
    Problem* dense = nullptr;
    PlainBlockSolver* plain = nullptr;
  };

  Candidate& Add(const std::string& name) {
    candidates_.emplace_back();
    candidates_.back().name = name;
    GetParam().build(candidates_.back().graph.get());
    return candidates_.back();
  }
  void AddDense(const std::string& name, LinearSolver solver) {
    Candidate& candidate = Add(name);
    auto problem = std::make_unique<Problem>(candidate.graph.get(), solver);
    candidate.dense = problem.get();
    candidate.system = problem.get();
    candidate.own = std::move(problem);
  }
  void AddPlain(const std::string& name) {
    Candidate& candidate = Add(name);
    auto solver = std::make_unique<PlainBlockSolver>(candidate.graph.get());
    solver->SetOrdering();
    candidate.plain = solver.get();
    candidate.system = solver.get();
    candidate.own = std::move(solver);
  }
  void AddChosen(const std::string& name, int threads, ReducedSolverType type, const IterativeOptions& options = {}) {
    Candidate& candidate = Add(name);
    candidate.optimizer = std::make_unique<SparseOptimizer>(candidate.graph.get(), threads);
    candidate.optimizer->SetReducedSolver(type, options);
    candidate.block = &candidate.optimizer->GetSolver();
    candidate.system = candidate.block;
  }
  void SetUp() override {
    AddDense("dense, LDLT", LinearSolver::kLdlt);
    AddDense("dense, PCG", LinearSolver::kPcg);
    AddChosen("sparse, 1 thread", 1, ReducedSolverType::kDenseCholesky);
    AddChosen("sparse, 2 threads", 2, ReducedSolverType::kDenseCholesky);
    AddChosen("sparse, 3 threads", 3, ReducedSolverType::kDenseCholesky);
    AddChosen("sparse, sparse Cholesky", 2, ReducedSolverType::kSparseCholesky);
    AddChosen("sparse, PCG", 1, ReducedSolverType::kPcg);
    AddChosen("sparse, implicit PCG", 2, ReducedSolverType::kImplicitPcg, IterativeOptions::Exact());
    AddChosen("sparse, power series", 1, ReducedSolverType::kPowerSeries, IterativeOptions::Exact());
    AddPlain("plain blocks");
  }

  std::vector<Candidate> candidates_;
};

TEST_P(AllSolvers, AgreeOnHessianAndGradient) {
  Problem& oracle = *candidates_[0].dense;
  oracle.MakeHessian();
  Random random(3);
  const VecX v = VecX::NullaryExpr(oracle.Size(), [&] { return random.Normal(); });
  for (Candidate& candidate : candidates_) {
    SCOPED_TRACE(candidate.name);
    ASSERT_EQ(candidate.system->Size(), oracle.Size());
    candidate.system->MakeHessian();
    EXPECT_LT(RelativeError(candidate.system->RightHandSide(), oracle.RightHandSide()), 1e-12);
    EXPECT_LT(RelativeError(candidate.system->HessianDiagonal(), oracle.HessianDiagonal()), 1e-12);
    EXPECT_LT(RelativeError(candidate.system->MultiplyHessian(v), oracle.MultiplyHessian(v)), 1e-12);
    EXPECT_NEAR(candidate.system->Cost(), oracle.Cost(), 1e-12 * oracle.Cost());
    double cost = oracle.Cost();
    EXPECT_EQ(candidate.system->MakeHessianAndCost(&cost), candidate.block != nullptr);
    EXPECT_NEAR(cost, oracle.Cost(), 1e-12 * oracle.Cost());
    EXPECT_NEAR(candidate.system->StateNorm(), oracle.StateNorm(), 1e-12 * oracle.StateNorm());
    if (candidate.block) {
      EXPECT_LT(RelativeError(candidate.block->DenseHessian(), oracle.Hessian()), 1e-12);
    }
    if (candidate.plain) {
      EXPECT_LT(RelativeError(candidate.plain->DenseHessian(), oracle.Hessian()), 1e-12);
    }
  }
}

TEST_P(AllSolvers, AgreeOnSchurComplementAndStep) {
  Problem& oracle = *candidates_[0].dense;
  for (Candidate& candidate : candidates_) candidate.system->MakeHessian();
  const double largest = oracle.HessianDiagonal().maxCoeff();
  for (const Damping damping : {Damping::kIdentity, Damping::kDiagonal}) {
    const double scale = damping == Damping::kIdentity ? largest : 1.0;
    for (const double lambda : {0.0, 1e-5 * scale, 1e-2 * scale, 10.0 * scale}) {
      if (lambda == 0.0 && GetParam().has_gauge_freedom) continue;
      SCOPED_TRACE("lambda = " + std::to_string(lambda));
      oracle.SetDamping(damping);
      VecX expected;
      ASSERT_TRUE(oracle.SolveLinearSystem(lambda, &expected));
      // The solvers sum in other orders: their steps differ by rounding times the condition of the damped system.
      MatXX H = oracle.Hessian();
      for (int i = 0; i < H.rows(); ++i) H(i, i) += lambda * oracle.DampingEntry(H(i, i));
      const VecX d = H.diagonal().cwiseSqrt().cwiseInverse();
      const VecX S = Eigen::SelfAdjointEigenSolver<MatXX>(d.asDiagonal() * H * d.asDiagonal()).eigenvalues();
      const double tolerance = std::max(1e-10, 1e-14 * S.maxCoeff() / S.minCoeff());
      for (Candidate& candidate : candidates_) {
        SCOPED_TRACE(candidate.name);
        candidate.system->SetDamping(damping);
        VecX step;
        ASSERT_TRUE(candidate.system->SolveLinearSystem(lambda, &step));
        EXPECT_LT(RelativeError(d.cwiseInverse().asDiagonal() * step, d.cwiseInverse().asDiagonal() * expected),
                  tolerance);
        EXPECT_NEAR(candidate.system->ModelCostChange(step), oracle.ModelCostChange(expected),
                    tolerance * oracle.ModelCostChange(expected));
        const MatXX S = candidate.block   ? candidate.block->SchurComplement()
                        : candidate.plain ? candidate.plain->SchurComplement()
                                          : MatXX();
        if (S.size() > 0 && oracle.GetOrdering().dim_landmarks > 0) {  // else it is implicit
          EXPECT_LT(RelativeError(S, oracle.SchurComplement()), 1e-10);
        }
      }
    }
  }
}

TEST_P(AllSolvers, AgreeOnWholeRuns) {
  for (const Algorithm algorithm : {Algorithm::kLevenbergMarquardt, Algorithm::kDogleg, Algorithm::kGaussNewton}) {
    if (GetParam().has_gauge_freedom && algorithm != Algorithm::kLevenbergMarquardt) continue;
    SolveOptions options;
    options.algorithm = algorithm;
    options.max_iterations = 6;                            // a slow descent magnifies rounding from step to step
    if (GetParam().has_gauge_freedom) options.tau = 1e-2;  // a gauge held by λ₀ alone would magnify rounding by 1/τ
    Summary expected;
    for (Candidate& candidate : candidates_) {
      SCOPED_TRACE(candidate.name + ", algorithm " + std::to_string(static_cast<int>(algorithm)));
      Graph fresh;
      GetParam().build(&fresh);
      for (size_t i = 0; i < fresh.Vertices().size(); ++i) {
        candidate.graph->Vertices()[i]->Parameters() = fresh.Vertices()[i]->Parameters();
      }
      candidate.system->SetDamping(Damping::kIdentity);  // an optimizer's own choice is the diagonal
      const Summary summary = Minimize(candidate.system, options);
      if (&candidate == &candidates_[0]) expected = summary;
      ASSERT_EQ(summary.trace.size(), expected.trace.size()) << summary.message << "; " << expected.message;
      EXPECT_EQ(summary.termination, expected.termination);
      for (size_t k = 0; k < summary.trace.size(); ++k) {
        EXPECT_NEAR(summary.trace[k].cost, expected.trace[k].cost, 1e-10 * expected.trace[k].cost) << "iteration " << k;
      }
    }
  }
}

TEST_P(AllSolvers, DoNotDependOnTheNumberOfThreads) {
  std::vector<VecX> steps;
  std::vector<Summary> summaries;
  for (const int threads : {1, 2, 3}) {
    Graph graph;
    GetParam().build(&graph);
    SparseOptimizer optimizer(&graph, threads);
    SparseSolver& solver = optimizer.GetSolver();
    solver.MakeHessian();
    VecX step;
    ASSERT_TRUE(solver.SolveLinearSystem(1e-3, &step));
    steps.push_back(step);
    summaries.push_back(optimizer.Solve());
    EXPECT_EQ(steps.back(), steps.front());
    ASSERT_EQ(summaries.back().trace.size(), summaries.front().trace.size());
    for (size_t k = 0; k < summaries.back().trace.size(); ++k) {
      EXPECT_EQ(summaries.back().trace[k].cost, summaries.front().trace[k].cost);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, AllSolvers, testing::ValuesIn(AllScenes()),
                         [](const testing::TestParamInfo<Scene>& info) { return info.param.name; });

}  // namespace
}  // namespace ch5::test
