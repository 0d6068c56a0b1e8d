#pragma once
/// H_mm⁻¹: the inverse of a block-diagonal matrix, one small block a landmark, made from the blocks' inverses.

#include <vector>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

class BlockDiagonal {
 public:
  /// An n×n matrix without blocks yet, `size` = n.
  explicit BlockDiagonal(int size) : size_(size) {}

  /// Puts `block`⁻¹ on the diagonal at row and column `index`.
  /// @return false if the block (k×k, symmetric) is not positive definite; nothing is put then
  bool SetInverse(int index, const Eigen::Ref<const MatXX>& block);

  /// The whole matrix with its zeros.
  MatXX Dense() const;
  int Size() const { return size_; }

  /// A·D and D·A at the cost of the blocks alone; A is m×n or n×m.
  MatXX LeftMultiply(const MatXX& A) const;   ///< A·D
  MatXX RightMultiply(const MatXX& A) const;  ///< D·A

 private:
  struct Block {
    int index;
    MatXX inverse;
  };
  int size_;
  std::vector<Block> blocks_;
};

inline MatXX operator*(const MatXX& A, const BlockDiagonal& D) { return D.LeftMultiply(A); }
inline MatXX operator*(const BlockDiagonal& D, const MatXX& A) { return D.RightMultiply(A); }
inline VecX operator*(const BlockDiagonal& D, const VecX& v) { return D.RightMultiply(v); }

}  // namespace ch5
