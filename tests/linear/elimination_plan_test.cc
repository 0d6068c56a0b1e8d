#include "ch5_backend/linear/elimination_plan.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/linear/block_matrices.h"

namespace ch5::test {
namespace {

TEST(EliminationPlan, ChainAndStarHaveNoFill) {
  // A star's natural order, center first, would fill the whole matrix.
  Ties star;
  for (int i = 1; i < 50; ++i) star.emplace_back(i, 0);
  for (const Ties& ties : {Chain(50), star}) {
    const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(50, 20), ties, 16);
    const EliminationPlan plan = PlanElimination(A);
    // 50 triangles of 20·21/2 and 49 blocks of 20². Merging may store the zeros of the last two blocks' triangles.
    const double exact = 50 * 210 + 49 * 400;
    EXPECT_GE(plan.num_factor_values, exact);
    EXPECT_LE(plan.num_factor_values, 1.02 * exact);
  }
}

TEST(EliminationPlan, IsAPermutationWithChildrenBeforeParents) {
  for (const SymmetricBlockMatrix& A : Matrices()) {
    const EliminationPlan plan = PlanElimination(A);
    ASSERT_EQ(plan.order.size(), static_cast<size_t>(A.NumColumns()));
    for (size_t k = 0; k < plan.order.size(); ++k) EXPECT_EQ(plan.position[plan.order[k]], static_cast<int>(k));
    int next = 0;
    for (size_t f = 0; f < plan.fronts.size(); ++f) {
      const Front& front = plan.fronts[f];
      EXPECT_EQ(front.first, next);
      EXPECT_LT(front.first, front.last);
      next = front.last;
      EXPECT_EQ(front.parent < 0, front.below.empty());
      if (front.parent < 0) continue;
      EXPECT_GT(front.parent, static_cast<int>(f));
      const Front& parent = plan.fronts[front.parent];
      for (const int block : front.below) {
        const bool is_pivot = block >= parent.first && block < parent.last;
        EXPECT_TRUE(is_pivot || std::binary_search(parent.below.begin(), parent.below.end(), block));
      }
    }
    EXPECT_EQ(next, A.NumColumns());
  }
}

TEST(EliminationPlan, OneFrontTakesTheMatrixAsDense) {
  const SymmetricBlockMatrix A = MakeMatrix({6, 3, 1}, Chain(3), 17);
  const EliminationPlan plan = PlanOneFront(A);
  ASSERT_EQ(plan.fronts.size(), 1u);
  EXPECT_EQ(plan.fronts[0].last, 3);
  EXPECT_EQ(plan.fronts[0].pivots, 10);
  EXPECT_EQ(plan.fronts[0].parent, -1);
  EXPECT_EQ(plan.order, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(plan.offset, (std::vector<int>{0, 6, 9, 10}));
}

}  // namespace
}  // namespace ch5::test
