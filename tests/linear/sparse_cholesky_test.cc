#include "ch5_backend/linear/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "ch5_backend/linear/elimination_plan.h"
#include "ch5_backend/linear/pivot_rule.h"
#include "ch5_backend/linear/selected_inverse.h"
#include "ch5_backend/math/eigen_types.h"
#include "ch5_backend/simulate/random.h"
#include "tests/linear/block_matrices.h"

namespace ch5::test {
namespace {

TEST(SparseCholesky, AnyNumberOfThreadsGivesTheSameBits) {
  const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(900, 6), Grid(30), 11);
  const VecX b = RandomVector(A.Size(), 22);
  VecX x_1;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    SparseCholesky cholesky;
    cholesky.Analyze(A, &pool);
    ASSERT_TRUE(cholesky.Factorize(A, VecX::Zero(A.Size())));
    VecX x;
    cholesky.Solve(b, &x);
    if (threads == 1) x_1 = x;
    EXPECT_EQ(x, x_1) << threads << " threads";
  }
}

// One diagonal entry, anywhere, is made too small: that must show, and leave nothing behind.
TEST(SparseCholesky, IndefiniteMatricesAreRefused) {
  const SymmetricBlockMatrix good = MakeMatrix(std::vector<int>(100, 6), Grid(10), 15);
  const VecX b = RandomVector(good.Size(), 25), none = VecX::Zero(good.Size());
  for (const int threads : {1, 2}) {
    ThreadPool pool(threads);
    SparseCholesky cholesky;
    cholesky.Analyze(good, &pool);
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
    // k³/6 of a triangle, k³/2 of the block below and k³/2 of its square.
    const double multiplications = 8000.0 / 6.0 * (50 + 6 * 49);
    EXPECT_GE(plan.multiplications, multiplications - 1.0);
    EXPECT_LE(plan.multiplications, 1.02 * multiplications);
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

SelectedInverse Invert(const SymmetricBlockMatrix& A, EliminationPlan plan) {
  SparseCholesky cholesky;
  cholesky.Analyze(A, std::move(plan), nullptr);
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

// The last pivot of A = L Lᵀ, as a part of the last diagonal entry.
double LastPivot(MatXX A) {
  const Eigen::Index n = A.rows();
  const double scale = A(n - 1, n - 1);
  for (Eigen::Index k = 0; k + 1 < n; ++k) {
    for (Eigen::Index j = k + 1; j < n; ++j) {
      for (Eigen::Index i = j; i < n; ++i) A(i, j) -= A(i, k) * A(j, k) / A(k, k);
    }
  }
  return A(n - 1, n - 1) / scale;
}

// D JᵀJ D for a random J; D has units from 1e-6 to 1e6. In J's last column only `part` is new.
MatXX Gram(int n, double part, Random* random) {
  MatXX J = MatXX::NullaryExpr(2 * n, n, [&] { return random->Normal(); });
  const VecX mix = VecX::NullaryExpr(n - 1, [&] { return random->Normal(); });
  J.col(n - 1) = J.leftCols(n - 1) * mix + part * J.col(n - 1);
  const VecX units = VecX::NullaryExpr(n, [&] { return std::pow(10.0, random->Uniform(-6.0, 6.0)); });
  J *= units.asDiagonal();
  return J.transpose() * J;
}

TEST(PivotRule, TellsSingularMatricesFromDefiniteOnesInAnyUnits) {
  Random random(1);
  for (const int n : {2, 3, 6, 15, 60, 100}) {
    for (int repeat = 0; repeat < 3; ++repeat) {
      EXPECT_LE(LastPivot(Gram(n, 0.0, &random)), PivotRounding(n)) << n << ": a column is a sum of others";
      // The column's part is known to half of the digits.
      EXPECT_GT(LastPivot(Gram(n, 1e-4, &random)), PivotRounding(n)) << n << ": no column is a sum of others";
    }
  }
}

}  // namespace
}  // namespace ch5::test
