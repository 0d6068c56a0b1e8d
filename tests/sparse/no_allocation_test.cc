// An iteration of the sparse solver takes no memory, and neither does a factorization: every way to it is counted.
#include <gtest/gtest.h>

#include <algorithm>

#include "ch5_backend/linear/sparse_cholesky.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/count_malloc.h"
#include "tests/linear/block_matrices.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

class NoAllocationOfScenes : public testing::TestWithParam<Scene> {};

TEST_P(NoAllocationOfScenes, AfterTheFirstIteration) {
#ifndef CH5_COUNTS_MALLOC
  GTEST_SKIP() << "malloc cannot be counted here";
#else
  Graph graph;
  GetParam().build(&graph);
  SparseOptimizer optimizer(&graph);
  SparseSolver& solver = optimizer.GetSolver();
  solver.SetDamping(Damping::kDiagonal);
  VecX delta_x;
  for (int iteration = 0; iteration < 3; ++iteration) {
    counting = iteration > 0;
    solver.MakeHessian();
    const bool solved = solver.SolveLinearSystem(1e-3, &delta_x);
    const double decrease = solver.ModelCostChange(delta_x);
    solver.UpdateStates(delta_x);
    solver.RefineLandmarks(2);
    const double chi = solver.Cost();
    solver.RollbackStates();
    counting = false;
    EXPECT_TRUE(solved && std::isfinite(chi) && std::isfinite(decrease));
  }
  const auto is_numeric = [](const auto& edge) { return edge->HasNumericJacobians(); };
  if (std::any_of(graph.Edges().begin(), graph.Edges().end(), is_numeric)) {
    allocations = 0;
    GTEST_SKIP() << "numeric Jacobians take memory";
  }
  EXPECT_EQ(allocations, 0u);
  counting = true;  // and the counter counts
  delete new int(3);
  VecX::Zero(100).eval();
  counting = false;
  EXPECT_GE(allocations, 1u);
  allocations = 0;
#endif
}

TEST(NoAllocation, InAFactorizationByAnyNumberOfThreads) {
#ifndef CH5_COUNTS_MALLOC
  GTEST_SKIP() << "malloc cannot be counted here";
#else
  const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(400, 6), Grid(20), 12);
  const VecX b = RandomVector(A.Size(), 23), min_pivot = VecX::Zero(A.Size());
  for (const int threads : {1, 2}) {
    ThreadPool pool(threads);
    SparseCholesky cholesky;
    cholesky.Analyze(A, &pool);
    VecX x(A.Size());
    allocations = 0;
    counting = true;
    for (int repeat = 0; repeat < 3; ++repeat) {
      EXPECT_TRUE(cholesky.Factorize(A, min_pivot));
      cholesky.Solve(b, &x);
    }
    counting = false;
    EXPECT_EQ(allocations, 0u) << threads << " threads";
  }
#endif
}

INSTANTIATE_TEST_SUITE_P(, NoAllocationOfScenes, testing::ValuesIn(AllScenes()),
                         [](const testing::TestParamInfo<Scene>& info) { return info.param.name; });

}  // namespace
}  // namespace ch5::test
