// Against Eigen, at sizes around those of registers and strips.
#include "ch5_backend/math/vector_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

MatXX RandomMatrix(int rows, int cols, Random* random) {
  return MatXX::NullaryExpr(rows, cols, [&] { return random->Uniform(-1.0, 1.0); });
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
