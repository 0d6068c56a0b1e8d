#include "ch5_backend/linear/selected_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/linear/block_matrices.h"

namespace ch5::test {
namespace {

SelectedInverse Invert(const SymmetricBlockMatrix& A, EliminationPlan plan) {
  SparseCholesky cholesky;
  cholesky.Analyze(A, std::move(plan));
  EXPECT_TRUE(cholesky.Factorize(A, VecX::Zero(A.Size())));
  return SelectedInverse(cholesky);
}

void ExpectBlock(const MatXX& block, const SymmetricBlockMatrix& A, const MatXX& inverse, int i, int j) {
  const auto expected = inverse.block(A.Offset(i), A.Offset(j), A.Dim(i), A.Dim(j));
  ASSERT_EQ(block.rows(), A.Dim(i));
  ASSERT_EQ(block.cols(), A.Dim(j));
  EXPECT_LT((block - expected).cwiseAbs().maxCoeff(), 1e-13 * inverse.cwiseAbs().maxCoeff()) << i << ", " << j;
}

TEST(SelectedInverse, HasEveryBlockOfAInBothOrders) {
  for (const SymmetricBlockMatrix& A : Matrices()) {
    if (A.Size() > 250) continue;  // the dense inverse takes too long
    const SelectedInverse inverse = Invert(A, PlanElimination(A));
    const MatXX expected = A.Dense().inverse();
    for (int j = 0; j < A.NumColumns(); ++j) {
      for (int block = A.ColumnBegin(j); block < A.ColumnBegin(j + 1); ++block) {
        const int i = A.Row(block);
        const auto lower = inverse.Block(i, j), upper = inverse.Block(j, i);
        ASSERT_TRUE(lower && upper) << i << ", " << j;
        ExpectBlock(*lower, A, expected, i, j);
        ExpectBlock(*upper, A, expected, j, i);
      }
    }
  }
}

TEST(SelectedInverse, HasNoBlockWhereTheFactorHasNone) {
  const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(60, 6), Chain(60), 31);
  const SelectedInverse inverse = Invert(A, PlanElimination(A));
  EXPECT_FALSE(inverse.Block(0, 30));
  EXPECT_FALSE(inverse.Block(59, 2));
}

TEST(SelectedInverse, OneFrontGivesTheWholeInverse) {
  const SymmetricBlockMatrix A = MakeMatrix(MixedDims(12), Chain(12), 32);
  const SelectedInverse inverse = Invert(A, PlanOneFront(A));
  const MatXX expected = A.Dense().inverse();
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) {
      const auto block = inverse.Block(i, j);
      ASSERT_TRUE(block);
      ExpectBlock(*block, A, expected, i, j);
    }
  }
}

}  // namespace
}  // namespace ch5::test
