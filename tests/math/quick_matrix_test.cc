// The dense room's matrices against Eigen's own.
#include "ch5_backend/math/quick_matrix.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "ch5_backend/math/dense_kernels.h"

namespace ch5 {
namespace {

// Entries without a pattern, the same everywhere.
MatXX Numbers(int rows, int columns, double seed) {
  return MatXX::NullaryExpr(rows, columns, [seed](Eigen::Index i, Eigen::Index j) {
    return std::sin(seed + 1.7 * static_cast<double>(i) + 0.3 * static_cast<double>(j * j));
  });
}

TEST(QuickMatrix, SumsIntoBlocksAreThoseOfEigen) {
  for (const int rows : {1, 2, 3, 6, 9}) {
    for (const int columns : {1, 3, 6}) {
      const MatXX A = Numbers(rows, columns, 0.1);
      MatXX expected = Numbers(15, 14, 0.2);
      QuickMatrix C(15, 14);
      C = expected;
      expected.block(4, 2, rows, columns) += A;
      expected.block(1, 5, columns, rows) += A.transpose();
      C.block(4, 2, rows, columns).noalias() += A;
      C.block(1, 5, columns, rows) += A.transpose();
      EXPECT_EQ(C, expected) << rows << "×" << columns;
    }
  }
}

TEST(QuickMatrix, ProductsAreThoseOfEigenOnAnyProcessor) {
  const std::string best = kernels::InstructionSet();
  for (const char* name : {"portable", "AVX2", "AVX-512"}) {
    if (!kernels::SetInstructionSet(name)) continue;
    for (const auto& [m, k, n] : {std::array{1, 1, 1}, {6, 5, 6}, {7, 64, 3}, {20, 65, 31}, {3, 200, 12}, {4, 0, 5}}) {
      const MatXX A_plain = Numbers(m, k, 0.3), B = Numbers(k, n, 0.4);
      QuickMatrix A(m, k);
      A = A_plain;
      EXPECT_LT((A * B - A_plain.lazyProduct(B)).norm(), 1e-13 * (k + 1)) << name << " " << m << " " << k << " " << n;
      const VecX v = Numbers(k, 1, 0.5);
      EXPECT_LT((A * v - A_plain.lazyProduct(v)).norm(), 1e-13 * (k + 1));
    }
  }
  kernels::SetInstructionSet(best.c_str());
}

TEST(MatrixView, LooksAtABlockWithoutACopy) {
  MatXX H = Numbers(8, 8, 0.6);
  const MatXX& constant = H;
  MatrixView view;
  view = constant.block(2, 3, 4, 5);
  EXPECT_EQ(view.data(), &H(2, 3));
  H(3, 4) = 7.0;
  EXPECT_EQ(view(1, 1), 7.0);
  EXPECT_EQ(view, H.block(2, 3, 4, 5));
}

TEST(MatrixView, KeepsTheValuesOfAnExpression) {
  const MatXX H = Numbers(8, 8, 0.7);
  MatrixView view, other;
  view = H.block(2, 3, 4, 5);
  other = view.transpose();
  EXPECT_EQ(other, H.block(2, 3, 4, 5).transpose());
  view = view.transpose() * 2.0;
  EXPECT_EQ(view, 2.0 * other);
  other = view;
  EXPECT_NE(other.data(), view.data());
  EXPECT_EQ(other, view);
}

}  // namespace
}  // namespace ch5
