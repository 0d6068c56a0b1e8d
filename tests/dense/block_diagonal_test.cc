#include "ch5_backend/dense/block_diagonal.h"

#include <gtest/gtest.h>

#include "ch5_backend/linear/pivot_rule.h"

namespace ch5::test {
namespace {

// Blocks of 1, 3 and 2 rows; row 4 has no block.
MatXX Blocks() {
  MatXX A = MatXX::Zero(7, 7);
  A(0, 0) = 4.0;
  A.block(1, 1, 3, 3) << 4, 1, 0, 1, 3, 1, 0, 1, 5;
  A.block(5, 5, 2, 2) << 2, 1, 1, 2;
  return A;
}

BlockDiagonal Inverse() {
  const MatXX A = Blocks();
  BlockDiagonal D(7);
  EXPECT_TRUE(D.SetInverse(0, A.block(0, 0, 1, 1)));
  EXPECT_TRUE(D.SetInverse(1, A.block(1, 1, 3, 3)));
  EXPECT_TRUE(D.SetInverse(5, A.block(5, 5, 2, 2)));
  return D;
}

TEST(BlockDiagonal, HoldsTheInverseOfEachBlock) {
  MatXX identity = MatXX::Identity(7, 7);
  identity(4, 4) = 0.0;
  EXPECT_EQ(Inverse().Size(), 7);
  EXPECT_LT((Inverse().Dense() * Blocks() - identity).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(BlockDiagonal, MultipliesLikeTheDenseMatrix) {
  const BlockDiagonal D = Inverse();
  const VecX numbers = VecX::LinSpaced(21, -3.0, 7.0);
  const MatXX A = Eigen::Map<const MatXX>(numbers.data(), 3, 7).array().square();
  EXPECT_LT((A * D - A * D.Dense()).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_LT((D * A.transpose() - D.Dense() * A.transpose()).cwiseAbs().maxCoeff(), 1e-14);
  const VecX v = VecX::LinSpaced(7, 1.0, 2.0);
  EXPECT_LT((D * (v + v) - 2.0 * D.Dense() * v).norm(), 1e-14) << "any expression will do";
}

TEST(BlockDiagonal, RefusesBlocksThatAreNotPositiveDefinite) {
  BlockDiagonal D(3);
  EXPECT_FALSE(D.SetInverse(0, MatXX::Zero(1, 1)));
  EXPECT_FALSE(D.SetInverse(0, MatXX::Constant(1, 1, -1.0)));
  EXPECT_FALSE(D.SetInverse(0, MatXX::Ones(3, 3))) << "singular";
  MatXX nearly = MatXX::Ones(2, 2);
  nearly(1, 1) += 0.5 * PivotRounding(2);
  EXPECT_FALSE(D.SetInverse(0, nearly)) << "its second pivot is rounding";
  nearly(1, 1) += 2.0 * PivotRounding(2);
  EXPECT_TRUE(D.SetInverse(1, nearly));
  EXPECT_EQ(D.Dense()(0, 0), 0.0) << "nothing was put for those refused";
}

}  // namespace
}  // namespace ch5::test
