#include "ch5_backend/linear/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/linear/block_matrices.h"

namespace ch5::test {
namespace {

TEST(SparseCholesky, SolvesLikeTheDenseOracle) {
  for (const SymmetricBlockMatrix& A : Matrices()) {
    const VecX b = RandomVector(A.Size(), 20), expected = SolveByEigen(A, b);
    SparseCholesky cholesky;
    cholesky.Analyze(A);
    ASSERT_TRUE(cholesky.Factorize(A, VecX::Zero(A.Size())));
    VecX x;
    cholesky.Solve(b, &x);
    // The matrices are dominated by their diagonals: nothing is lost but the last digits.
    EXPECT_LT((x - expected).norm(), 1e-13 * expected.norm()) << A.NumColumns() << " blocks of " << A.Dim(0);
  }
}

TEST(SparseCholesky, AnyNumberOfThreadsGivesTheSameBits) {
  const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(900, 6), Grid(30), 11);
  const VecX b = RandomVector(A.Size(), 22);
  VecX x_1;
  for (const int threads : {1, 2, 5}) {
    SparseCholesky cholesky(threads);
    cholesky.Analyze(A);
    ASSERT_TRUE(cholesky.Factorize(A, VecX::Zero(A.Size())));
    VecX x;
    cholesky.Solve(b, &x);
    if (threads == 1) x_1 = x;
    EXPECT_EQ(x, x_1) << threads << " threads";
  }
}

TEST(SparseCholesky, NewValuesInTheOldPattern) {
  const SymmetricBlockMatrix first = MakeMatrix(MixedDims(64), Grid(8), 13);
  const SymmetricBlockMatrix second = MakeMatrix(MixedDims(64), Grid(8), 14);
  const VecX b = RandomVector(first.Size(), 24);
  SparseCholesky cholesky;
  cholesky.Analyze(first);
  ASSERT_TRUE(cholesky.Factorize(first, VecX::Zero(first.Size())));
  ASSERT_TRUE(cholesky.Factorize(second, VecX::Zero(first.Size())));
  VecX x;
  cholesky.Solve(b, &x);
  EXPECT_LT((x - SolveByEigen(second, b)).norm(), 1e-13 * x.norm());
}

// One diagonal entry, anywhere, is made too small: that must show, and leave nothing behind.
TEST(SparseCholesky, IndefiniteMatricesAreRefused) {
  const SymmetricBlockMatrix good = MakeMatrix(std::vector<int>(100, 6), Grid(10), 15);
  const VecX b = RandomVector(good.Size(), 25), none = VecX::Zero(good.Size());
  for (const int threads : {1, 2}) {
    SparseCholesky cholesky(threads);
    cholesky.Analyze(good);
    for (int j = 0; j < 100; j += 9) {
      for (const double bad : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN()}) {
        SymmetricBlockMatrix A = good;
        A.Values(A.ColumnBegin(j))[(j % 6) * (Stride(6) + 1)] = bad;
        EXPECT_FALSE(cholesky.Factorize(A, none)) << "block " << j << ", entry " << bad;
      }
    }
    ASSERT_TRUE(cholesky.Factorize(good, none));
    VecX x;
    cholesky.Solve(b, &x);
    EXPECT_LT((x - SolveByEigen(good, b)).norm(), 1e-13 * x.norm());
  }
}

}  // namespace
}  // namespace ch5::test
