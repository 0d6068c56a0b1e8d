// Both rooms on the same scenes: the dense one is the oracle.
#include <gtest/gtest.h>

#include "ch5_backend/solve/problem.h"
#include "ch5_backend/solve/sparse_optimizer.h"
#include "ch5_backend/world/mono_ba.h"

namespace ch5 {
namespace {

TEST(Rooms, GiveTheSameNormalEquationsAndStep) {
  MonoBa scene;
  BuildMonoBa(SimulateMonoBa({}), Gauge::kFixTwoFrames, 1.0, 0.0, &scene);
  Problem dense(&scene.graph);
  dense.MakeHessian();
  BlockSolver<6, 1> block(&scene.graph);
  block.MakeHessian();
  EXPECT_LT((block.DenseHessian() - dense.Hessian()).norm(), 1e-12 * dense.Hessian().norm());
  EXPECT_LT((block.RightHandSide() - dense.RightHandSide()).norm(), 1e-12 * dense.RightHandSide().norm());
  VecX expected, step;
  ASSERT_TRUE(dense.SolveLinearSystem(1e-3, &expected));
  ASSERT_TRUE(block.SolveLinearSystem(1e-3, &step));
  EXPECT_LT((step - expected).norm(), 1e-10 * expected.norm());
}

}  // namespace
}  // namespace ch5
