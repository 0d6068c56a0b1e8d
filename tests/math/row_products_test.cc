#include "ch5_backend/math/row_products.h"

#include <gtest/gtest.h>

#include "ch5_backend/math/eigen_types.h"

namespace ch5::test {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// As Eigen's products, for every number of registers; nothing is written behind C.
TEST(RowProducts, AreThoseOfAnySize) {
  for (int rows = 0; rows <= 16; ++rows) {
    for (int columns = 1; columns <= 41; ++columns) {
      const MatXX M = MatXX::Random(rows, rows), W = M + M.transpose();
      RowMajor X = RowMajor::Zero(rows, kernels::RowStride(columns)), Y = X;
      X.leftCols(columns).setRandom();
      if (rows > 2) X.row(2).setZero();  // what is skipped
      kernels::MultiplyRows(rows, columns, W.data(), X.data(), Y.data());
      EXPECT_LT((Y - W * X).norm(), 1e-13) << rows << "x" << columns;
      VecX memory = VecX::Constant(columns * columns + 8, 7.0);
      kernels::NegativeProducts(rows, columns, X.data(), Y.data(), memory.data());
      const MatXX C =
          Eigen::Map<MatXX>(memory.data(), columns, columns) + (X.transpose() * W * X).topLeftCorner(columns, columns);
      EXPECT_LT(MatXX(C.triangularView<Eigen::Lower>()).norm(), 1e-12) << rows << "x" << columns;
      EXPECT_EQ(memory.tail(8), VecX::Constant(8, 7.0)) << rows << "x" << columns;
    }
  }
}

}  // namespace
}  // namespace ch5::test
