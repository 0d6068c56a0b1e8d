#include "ch5_backend/linear/block_matrix.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "tests/linear/block_matrices.h"

namespace ch5::test {
namespace {

//  Blocks 00, 20, 11, 22 of sizes 2, 3, 5, each number different.
SymmetricBlockMatrix Picture() {
  SymmetricBlockMatrix A;
  A.SetPattern({2, 3, 5}, {{0, 2}, {1}, {2}});
  double value = 0.0;
  for (int j = 0; j < 3; ++j) {
    for (int block = A.ColumnBegin(j); block < A.ColumnBegin(j + 1); ++block) {
      const int i = A.Row(block), stride = Stride(A.Dim(i));
      for (int c = 0; c < A.Dim(j); ++c) {
        for (int r = i == j ? c : 0; r < A.Dim(i); ++r) {
          A.Values(block)[c * stride + r] = ++value;
          if (i == j) A.Values(block)[r * stride + c] = value;
        }
      }
    }
  }
  return A;
}

TEST(SymmetricBlockMatrix, StoresTheLowerBlocksColumnByColumn) {
  const SymmetricBlockMatrix A = Picture();
  EXPECT_EQ(A.NumColumns(), 3);
  EXPECT_EQ(A.NumBlocks(), 4);
  EXPECT_EQ(A.Size(), 10);
  EXPECT_EQ(A.Offset(2), 5);
  EXPECT_EQ(A.Find(0, 0), 0);
  EXPECT_EQ(A.Find(2, 0), 1);
  EXPECT_EQ(A.Find(1, 1), 2);
  EXPECT_EQ(A.Find(2, 2), 3);
  EXPECT_EQ(A.Find(1, 0), -1);
  EXPECT_EQ(A.Find(2, 1), -1);
  EXPECT_EQ(A.Row(1), 2);
  EXPECT_EQ(A.ColumnBegin(1), 2);
}

TEST(SymmetricBlockMatrix, DenseIsSymmetricWithZerosBetweenTheBlocks) {
  const SymmetricBlockMatrix A = Picture();
  const MatXX D = A.Dense();
  EXPECT_EQ(D, D.transpose());
  MatXX corner(2, 2);
  corner << 1, 2, 2, 3;
  EXPECT_EQ(D.topLeftCorner(2, 2), corner);
  EXPECT_EQ(D.block(5, 0, 5, 1), VecX::LinSpaced(5, 4, 8));
  EXPECT_EQ(D.block(5, 1, 5, 1), VecX::LinSpaced(5, 9, 13));
  EXPECT_EQ(D.block(2, 0, 3, 2), MatXX::Zero(3, 2));
  EXPECT_EQ(D.block(5, 2, 5, 3), MatXX::Zero(5, 3));
  EXPECT_EQ(A.Diagonal(), D.diagonal());
}

TEST(SymmetricBlockMatrix, BlocksBeginOnWholeRegistersAndPaddingIsZero) {
  for (const SymmetricBlockMatrix& A : Matrices()) {
    double sum = 0.0, sum_of_blocks = 0.0;
    for (int k = 0; k < A.NumValues(); ++k) sum += std::abs(A.Values(0)[k]);
    for (int j = 0; j < A.NumColumns(); ++j) {
      for (int block = A.ColumnBegin(j); block < A.ColumnBegin(j + 1); ++block) {
        EXPECT_EQ(reinterpret_cast<uintptr_t>(A.Values(block)) % 32, 0u);
        EXPECT_EQ(A.Values(block), A.Values(0) + A.ValueBegin(block));
        const Eigen::Map<const MatXX, 0, Eigen::OuterStride<>> values(
            A.Values(block), A.Dim(A.Row(block)), A.Dim(j), Eigen::OuterStride<>(Stride(A.Dim(A.Row(block)))));
        sum_of_blocks += values.cwiseAbs().sum();
      }
    }
    EXPECT_NEAR(sum, sum_of_blocks, 1e-12 * sum);
  }
}

TEST(SymmetricBlockMatrix, CopyLowerLeavesTheUpperHalfOfOtherBlocksAlone) {
  const SymmetricBlockMatrix A = Picture();
  MatXX copy = MatXX::Constant(10, 10, 77.0);
  A.CopyLower(copy.data());
  EXPECT_EQ(MatXX(copy.triangularView<Eigen::Lower>()), MatXX(A.Dense().triangularView<Eigen::Lower>()));
  EXPECT_EQ(copy.topRightCorner(5, 5), MatXX::Constant(5, 5, 77.0));
}

TEST(SymmetricBlockMatrix, ANewPatternForgetsTheOldOne) {
  SymmetricBlockMatrix A = Picture();
  A.SetPattern({1}, {{0}});
  EXPECT_EQ(A.Size(), 1);
  EXPECT_EQ(A.Dense(), MatXX::Zero(1, 1));
}

}  // namespace
}  // namespace ch5::test
