// The dense loops and those of vectors, around the sizes of registers and strips. CH5_SIMD chooses which version is tested.
#include "ch5_backend/math/dense_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "ch5_backend/math/vector_kernels.h"
#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

// Matrices lie inside larger ones; what is around them must not change.
MatXX RandomMatrix(int rows, int cols, Random* random) {
  return MatXX::NullaryExpr(rows, cols, [&] { return random->Uniform(-1.0, 1.0); });
}

TEST(DenseKernels, ProductsAgreeWithEigen) {
  Random random(26);
  for (const int m : {1, 5, 8, 17, 24, 50, 205}) {
    for (const int n : {1, 3, 6, 13, 30}) {
      for (const int k : {0, 1, 6, 65, 130}) {
        const MatXX A = RandomMatrix(m + 4, k + 9, &random), B = RandomMatrix(n + 3, k + 9, &random);
        MatXX C = RandomMatrix(m + 2, n + 1, &random), expected = C;
        expected.topLeftCorner(m, n) -= A.topLeftCorner(m, k) * B.topLeftCorner(n, k).transpose();
        kernels::SubtractProductABt(m, n, k, A.data(), m + 4, B.data(), n + 3, C.data(), m + 2);
        // k products of numbers below 1.
        EXPECT_LT((C - expected).cwiseAbs().maxCoeff(), 1e-15 * (k + 4)) << m << ' ' << n << ' ' << k;
        if (k == 0) continue;
        C.topLeftCorner(m, n).setConstant(std::numeric_limits<double>::quiet_NaN());
        expected.topLeftCorner(m, n) = -A.topLeftCorner(m, k) * B.topLeftCorner(n, k).transpose();
        kernels::SubtractProductABt(m, n, k, A.data(), m + 4, B.data(), n + 3, C.data(), m + 2,
                                    kernels::Accumulate::kNo);
        EXPECT_LT((C - expected).cwiseAbs().maxCoeff(), 1e-15 * (k + 4)) << m << ' ' << n << ' ' << k;
      }
    }
  }
}

TEST(DenseKernels, SymmetricProductsAgreeWithEigen) {
  Random random(27);
  for (const int n : {1, 5, 6, 8, 23, 48, 200}) {
    for (const int k : {0, 1, 6, 65}) {
      const MatXX A = RandomMatrix(n + 4, k + 9, &random);
      MatXX C = RandomMatrix(n + 3, n + 3, &random), expected = C;
      expected.topLeftCorner(n, n) -= A.topLeftCorner(n, k) * A.topLeftCorner(n, k).transpose();
      kernels::SubtractProductAAt(n, k, A.data(), n + 4, C.data(), n + 3);
      const MatXX wrong = C - expected;
      EXPECT_LT(MatXX(wrong.topLeftCorner(n, n).triangularView<Eigen::Lower>()).cwiseAbs().maxCoeff(), 1e-15 * (k + 4));
      EXPECT_EQ(wrong.rightCols(3).cwiseAbs().maxCoeff(), 0.0);
      EXPECT_EQ(wrong.bottomRows(3).cwiseAbs().maxCoeff(), 0.0);
    }
  }
}

TEST(DenseKernels, FactorAndSolveAgreeWithEigen) {
  Random random(28);
  for (const int k : {1, 2, 6, 7, 12, 30, 96, 97, 250}) {
    const MatXX root = RandomMatrix(k, k, &random);
    const MatXX A = root * root.transpose() + k * MatXX::Identity(k, k);
    MatXX L = MatXX::Zero(k + 2, k + 25);
    L.topLeftCorner(k, k) = A.triangularView<Eigen::Lower>();
    MatXX by_threads = L;
    ThreadPool pool(3);
    ASSERT_TRUE(kernels::Factor(k, L.data(), k + 2, VecX(VecX::Zero(k)).data()));
    ASSERT_TRUE(kernels::Factor(k, by_threads.data(), k + 2, VecX(VecX::Zero(k)).data(), &pool));
    by_threads = MatXX(by_threads.topLeftCorner(k, k).triangularView<Eigen::Lower>());
    L = MatXX(L.topLeftCorner(k, k).triangularView<Eigen::Lower>());
    EXPECT_LT((L * L.transpose() - A).cwiseAbs().maxCoeff(), 1e-14 * A.maxCoeff()) << k;
    EXPECT_EQ(by_threads, L) << k << ": the same bits";

    for (const int m : {1, 7, 8, 33}) {
      const MatXX X = RandomMatrix(m, k, &random);
      MatXX Y = MatXX::Zero(m + 1, k + 25);
      Y.topLeftCorner(m, k) = X;
      kernels::SolveRows(m, k, L.data(), k, Y.data(), m + 1);
      EXPECT_LT((Y.topLeftCorner(m, k) * L.transpose() - X).cwiseAbs().maxCoeff(), 1e-13) << m << ' ' << k;
      EXPECT_EQ(Y.bottomRows(1).cwiseAbs().maxCoeff(), 0.0);
    }

    MatXX indefinite = MatXX::Zero(k, k + 25);
    indefinite.leftCols(k) = A;
    indefinite(k - 1, k - 1) = -1.0;
    EXPECT_FALSE(kernels::Factor(k, indefinite.data(), k, VecX(VecX::Zero(k)).data()));
  }
}

TEST(VectorKernels, ProductsAgreeWithEigen) {
  Random random(41);
  for (const int m : {0, 1, 3, 7, 8, 9, 15, 75}) {
    for (const int n : {0, 1, 3, 4, 5, 42}) {
      const MatXX A = RandomMatrix(m + 2, n, &random), block = A.topRows(m);
      const VecX x = RandomMatrix(n, 1, &random), z = RandomMatrix(m, 1, &random);
      VecX y = RandomMatrix(m + 1, 1, &random), w = RandomMatrix(n + 1, 1, &random);  // with one number behind
      VecX expected_y = y, expected_w = w;
      expected_y.head(m) -= block * x;
      expected_w.head(n) -= block.transpose() * z;
      kernels::SubtractProductAx(m, n, A.data(), m + 2, x.data(), y.data());
      kernels::SubtractProductAtx(m, n, A.data(), m + 2, z.data(), w.data());
      EXPECT_LT((y - expected_y).norm(), 1e-15 * (m + n + 4)) << m << ' ' << n;
      EXPECT_LT((w - expected_w).norm(), 1e-15 * (m + n + 4)) << m << ' ' << n;
    }
  }
}

TEST(VectorKernels, ProductsWithThreeColumnsOrRowsAgreeWithEigen) {
  Random random(43);
  const Mat33 B = RandomMatrix(3, 3, &random);
  for (const int m : {0, 1, 3, 7, 8, 9, 15, 76}) {
    MatXX C = RandomMatrix(m + 2, 4, &random), D = RandomMatrix(5, m + 1, &random);
    MatXX expected_C = C, expected_D = D;
    expected_C.topLeftCorner(m, 3) *= B;
    expected_D.topLeftCorner(3, m).applyOnTheLeft(B.transpose());
    kernels::MultiplyThreeColumns(m, B.data(), C.data(), m + 2);
    kernels::MultiplyThreeRows(m, B.data(), D.data(), 5);
    EXPECT_LT((C - expected_C).norm(), 1e-15 * (m + 4)) << m;
    EXPECT_LT((D - expected_D).norm(), 1e-15 * (m + 4)) << m;
    EXPECT_EQ(C.bottomRows(2), expected_C.bottomRows(2));
    EXPECT_EQ(D.bottomRows(2), expected_D.bottomRows(2));
  }
}

TEST(VectorKernels, SolvesAgreeWithEigen) {
  Random random(42);
  for (const int k : {0, 1, 2, 3, 4, 5, 9, 18, 93}) {
    const MatXX L = RandomMatrix(k + 3, k, &random) + k * MatXX::Identity(k + 3, k);  // above the diagonal: anything
    const MatXX triangle = L.topRows(k).triangularView<Eigen::Lower>();
    VecX x = RandomMatrix(k + 1, 1, &random), y = x;
    const VecX before = x;
    kernels::SolveLower(k, L.data(), k + 3, x.data());
    kernels::SolveLowerTranspose(k, L.data(), k + 3, y.data());
    EXPECT_LT((triangle * x.head(k) - before.head(k)).norm(), 1e-15 * (k + 4)) << k;
    EXPECT_LT((triangle.transpose() * y.head(k) - before.head(k)).norm(), 1e-15 * (k + 4)) << k;
    EXPECT_EQ(x[k], before[k]);
    EXPECT_EQ(y[k], before[k]);
  }
}

}  // namespace
}  // namespace ch5
