// CHOLMOD behind our interface, where it is installed: the same steps as our own solvers.
#include "ch5_backend/linear/cholmod/cholmod_solver.h"

#include <gtest/gtest.h>

#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/scenes.h"

namespace ch5::test {
namespace {

class Cholmod : public testing::TestWithParam<Scene> {};

TEST_P(Cholmod, FindsTheStepOfTheDenseSolver) {
  Graph graphs[2];
  VecX steps[2];
  for (int k = 0; k < 2; ++k) {
    GetParam().build(&graphs[k]);
    SparseSolver solver(&graphs[k]);
    solver.SetOrdering();
    if (k == 0) {
      solver.SetReducedSolver(ReducedSolverType::kDenseCholesky);
    } else {
      solver.SetReducedSolver(MakeCholmodSolver());
    }
    solver.SetDamping(Damping::kDiagonal);
    solver.SetOrdering();
    solver.MakeHessian();
    ASSERT_TRUE(solver.SolveLinearSystem(1e-3, &steps[k]));
    ASSERT_TRUE(solver.SolveLinearSystem(1e-2, &steps[k])) << "the same pattern once more";
  }
  EXPECT_LT((steps[1] - steps[0]).norm(), 1e-9 * steps[0].norm());
}

INSTANTIATE_TEST_SUITE_P(Scenes, Cholmod, testing::ValuesIn(AllScenes()),
                         [](const testing::TestParamInfo<Scene>& info) { return info.param.name; });

TEST(CholmodSolver, RefusesAnIndefiniteSystem) {
  SymmetricBlockMatrix S;
  S.SetPattern({2, 3}, {{0, 1}, {1}});
  for (int j = 0; j < 2; ++j) {
    double* diagonal = S.Values(S.ColumnBegin(j));
    for (int i = 0; i < S.Dim(j); ++i) diagonal[i * Stride(S.Dim(j)) + i] = 2.0;
  }
  const auto solver = MakeCholmodSolver();
  const VecX b = VecX::LinSpaced(5, 2, 10), scale = VecX::Constant(5, 2.0);
  VecX x;
  solver->Prepare(S, nullptr);
  ASSERT_TRUE(solver->Solve(S, b, scale, &x));
  EXPECT_LT((x - 0.5 * b).norm(), 1e-14);
  S.Values(S.ColumnBegin(1))[0] = -2.0;
  EXPECT_FALSE(solver->Solve(S, b, scale, &x));
  S.Values(S.ColumnBegin(1))[0] = 2.0;
  EXPECT_TRUE(solver->Solve(S, b, scale, &x)) << "it recovers";
}

}  // namespace
}  // namespace ch5::test
