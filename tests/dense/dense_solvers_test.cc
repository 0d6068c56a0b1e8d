#include "ch5_backend/dense/dense_solvers.h"

#include <gtest/gtest.h>

#include "ch5_backend/dense/block_diagonal.h"
#include "ch5_backend/linear/pivot_rule.h"
#include "tests/linear/block_matrices.h"

namespace ch5::test {
namespace {

// JᵀJ of 12 random rows.
MatXX Gram(int n, uint64_t seed) {
  const VecX numbers = RandomVector(12 * n, seed);
  const Eigen::Map<const MatXX> J(numbers.data(), 12, n);
  return J.transpose() * J;
}

TEST(DenseSolvers, RefuseIndefiniteSystems) {
  MatXX A = Gram(8, 2);
  A(0, 0) = -1.0;
  const VecX b = VecX::Ones(8);
  VecX x;
  EXPECT_FALSE(SolveLdlt(A, b, &x));
  EXPECT_FALSE(SolvePcg(A, b, 100, 1e-14, &x));
}

TEST(DenseSolvers, LdltRefusesSingularSystemsInAnyUnits) {
  const VecX units = (VecX(4) << 1e-8, 1.0, 1e4, 1e8).finished();
  VecX x;
  EXPECT_FALSE(SolveLdlt(MatXX::Ones(3, 3), VecX::Ones(3), &x));
  EXPECT_FALSE(SolveLdlt(units.asDiagonal() * MatXX::Ones(4, 4) * units.asDiagonal(), VecX::Ones(4), &x));
  const MatXX definite = units.asDiagonal() * Gram(4, 3) * units.asDiagonal();
  const VecX b = units.asDiagonal() * VecX::Ones(4);
  ASSERT_TRUE(SolveLdlt(definite, b, &x)) << "the units differ, but every direction is determined";
  EXPECT_LT(((definite * x - b).array() / units.array()).abs().maxCoeff(), 1e-12);
}

TEST(DenseSolvers, PcgStopsAtTheToleranceOrAfterTheLastIteration) {
  const MatXX A = Gram(8, 4);
  const VecX b = VecX::LinSpaced(8, -1.0, 2.0);
  VecX first, loose;
  ASSERT_TRUE(SolvePcg(A, b, 1, 0.0, &first));  // the original course's code lost its first step
  EXPECT_LT((A * first - b).norm(), b.norm());
  EXPECT_GT((A * first - b).norm(), 1e-3 * b.norm());
  ASSERT_TRUE(SolvePcg(A, b, 100, 1e-3, &loose));
  EXPECT_LE((A * loose - b).norm(), 1.001e-3 * b.norm());
  EXPECT_GT((A * loose - b).norm(), 1e-12 * b.norm());
  ASSERT_TRUE(SolvePcg(A, VecX::Zero(8), 100, 1e-14, &loose));
  EXPECT_EQ(loose, VecX::Zero(8));
}

TEST(DenseSolvers, AnEmptySystemIsSolved) {
  VecX x = VecX::Ones(3);
  EXPECT_TRUE(SolveLdlt(MatXX(0, 0), VecX(0), &x));
  EXPECT_EQ(x.size(), 0);
  EXPECT_TRUE(SolvePcg(MatXX(0, 0), VecX(0), 100, 1e-14, &x));
  EXPECT_EQ(x.size(), 0);
}

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
