#pragma once
/// H_mm⁻¹: the inverse of a block-diagonal matrix with one small block per landmark is block diagonal, too.

#include <cassert>
#include <vector>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

class BlockDiagonal {
 public:
  /// An n×n matrix without blocks yet, `size` = n.
  explicit BlockDiagonal(int size) : size_(size) {}

  /// Puts `block`⁻¹ on the diagonal at row and column `index`.
  /// @param block  k×k, symmetric
  /// @return false if the block is not positive definite by the measure of linear/pivot_rule.h,
  ///         and changes nothing then
  bool SetInverse(int index, const Eigen::Ref<const MatXX>& block);

  /// The whole matrix, zeros included.
  MatXX Dense() const;
  int Size() const { return size_; }

  /// A·D and D·A at the cost of the blocks alone; A is m×n or n×m.
  MatXX LeftMultiply(const Eigen::Ref<const MatXX>& A) const;   ///< A·D
  MatXX RightMultiply(const Eigen::Ref<const MatXX>& A) const;  ///< D·A

 private:
  struct Block {
    int index;
    MatXX inverse;
  };
  int size_;
  std::vector<Block> blocks_;
};

/// A·D, D·A and D·v for any Eigen expression. The sizes are asserted here, in the caller's file, which may be
/// compiled with assertions where the library is not.
template <typename Expression>
MatXX operator*(const Eigen::MatrixBase<Expression>& A, const BlockDiagonal& D) {
  assert(A.cols() == D.Size() && "A·D: A must have as many columns as D has rows");
  return D.LeftMultiply(A.derived());
}
template <typename Expression>
typename Expression::PlainObject operator*(const BlockDiagonal& D, const Eigen::MatrixBase<Expression>& A) {
  assert(A.rows() == D.Size() && "D·A: A must have as many rows as D has columns");
  return D.RightMultiply(A.derived());
}

}  // namespace ch5
