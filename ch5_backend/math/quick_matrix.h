#pragma once
/// Dense matrices without Eigen's costs where the dense room feels them: sums into small blocks, large products,
/// copies of blocks.

#include <new>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// A matrix like any other, but quick at two things: sums into small blocks, as MakeHessian needs them, and products
/// that it begins, A·B, which run through the kernels for the processor at hand.
class QuickMatrix : public MatXX {
 public:
  /// A block to be written; `+=` of a whole matrix costs little more than its numbers. There is no aliasing to fear.
  class Block : public Eigen::Block<MatXX> {
   public:
    using Base = Eigen::Block<MatXX>;
    using Base::Base;
    using Base::operator=;
    using Base::operator+=;
    Block& noalias() { return *this; }
    Block& operator+=(const MatXX& A) {
      eigen_assert(rows() == A.rows() && cols() == A.cols() && "the block and what is added differ in size");
      Add(A.data(), 1, A.rows());
      return *this;
    }
    Block& operator+=(const Eigen::Transpose<const MatXX>& A) {
      eigen_assert(rows() == A.rows() && cols() == A.cols() && "the block and what is added differ in size");
      Add(A.nestedExpression().data(), A.nestedExpression().rows(), 1);
      return *this;
    }

   private:
    // The steps are those from A's row to row and from column to column.
    void Add(const double* A, Eigen::Index row_step, Eigen::Index column_step);
  };

  using MatXX::MatXX;
  using MatXX::operator=;

  Block block(Eigen::Index row, Eigen::Index column, Eigen::Index rows, Eigen::Index columns) {
    return Block(*this, row, column, rows, columns);
  }
  Eigen::Block<const MatXX> block(Eigen::Index row, Eigen::Index column, Eigen::Index rows,
                                  Eigen::Index columns) const {
    return Eigen::Block<const MatXX>(*this, row, column, rows, columns);
  }
  template <int Rows, int Columns>
  auto block(Eigen::Index row, Eigen::Index column) {
    return MatXX::block<Rows, Columns>(row, column);
  }
};

/// A block of another matrix, looked at where it stands, without a copy: `V = H.block(…)`. Any other expression is
/// evaluated and kept. Read only.
class MatrixView : public Eigen::Map<const MatXX, 0, Eigen::OuterStride<>> {
 public:
  using Base = Eigen::Map<const MatXX, 0, Eigen::OuterStride<>>;
  MatrixView() : Base(nullptr, 0, 0, Eigen::OuterStride<>(0)) {}
  MatrixView(const MatrixView&) = delete;
  MatrixView& operator=(const MatrixView& other) { return *this = MatXX(other); }
  MatrixView& operator=(const Eigen::Block<const MatXX>& block) {
    LookAt(block.data(), block.rows(), block.cols(), block.outerStride());
    return *this;
  }
  template <typename Expression>
  MatrixView& operator=(const Eigen::MatrixBase<Expression>& values) {
    const MatXX evaluated = values;  // first: the expression may hold this view
    values_ = evaluated;
    LookAt(values_.data(), values_.rows(), values_.cols(), values_.rows());
    return *this;
  }

 private:
  // Eigen's way of letting a Map look elsewhere.
  void LookAt(const double* data, Eigen::Index rows, Eigen::Index columns, Eigen::Index stride) {
    new (static_cast<Base*>(this)) Base(data, rows, columns, Eigen::OuterStride<>(stride));
  }
  MatXX values_;
};

/// A·B by the kernels of dense_kernels.h; A m×k, B k×n.
MatXX Multiply(const Eigen::Ref<const MatXX>& A, const Eigen::Ref<const MatXX>& B);

/// A·B, or A·v as Eigen does it.
template <typename Expression>
auto operator*(const QuickMatrix& A, const Eigen::MatrixBase<Expression>& B) {
  const MatXX& A_plain = A;
  if constexpr (Expression::ColsAtCompileTime == 1) {
    return VecX(A_plain * B);
  } else {
    eigen_assert(A.cols() == B.rows() && "A·B: A must have as many columns as B has rows");
    return Multiply(A_plain, B.derived());
  }
}

}  // namespace ch5
