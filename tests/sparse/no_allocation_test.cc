// An iteration of the sparse solver takes no memory: every way to it is counted, Eigen's malloc included.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/scenes.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CH5_COUNTS_MALLOC

namespace {
thread_local bool counting = false;
thread_local int allocations = 0;
}  // namespace

// operator new ends here too.
extern "C" void* __libc_malloc(size_t size);
extern "C" void* malloc(size_t size) {
  if (counting) ++allocations;
  return __libc_malloc(size);
}
#endif

namespace ch5::test {
namespace {

class NoAllocation : public testing::TestWithParam<Scene> {};

TEST_P(NoAllocation, AfterTheFirstIteration) {
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
  EXPECT_EQ(allocations, 0);
  counting = true;  // and the counter counts
  delete new int(3);
  VecX::Zero(100).eval();
  counting = false;
  EXPECT_GE(allocations, 1);
  allocations = 0;
#endif
}

INSTANTIATE_TEST_SUITE_P(, NoAllocation, testing::ValuesIn(AllScenes()),
                         [](const testing::TestParamInfo<Scene>& info) { return info.param.name; });

}  // namespace
}  // namespace ch5::test
