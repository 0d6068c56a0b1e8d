#include "ch5_backend/dense/block_diagonal.h"

#include <Eigen/Cholesky>
#include <cassert>

#include "ch5_backend/linear/pivot_rule.h"

namespace ch5 {

bool BlockDiagonal::SetInverse(int index, const Eigen::Ref<const MatXX>& block) {
  assert(block.rows() == block.cols() && index >= 0 && index + block.rows() <= size_ && "the block lies outside");
  if (block.rows() == 1) {  // an inverse depth
    if (!(block(0, 0) > 0.0)) return false;
    blocks_.push_back({index, MatXX::Constant(1, 1, 1.0 / block(0, 0))});
    return true;
  }
  const Eigen::LLT<MatXX> llt(block);
  if (llt.info() != Eigen::Success) return false;
  // The depth of a point that is seen once has a pivot of rounding errors alone: its inverse would be random.
  const double rounding = PivotRounding(static_cast<int>(block.rows()));
  const VecX pivots = llt.matrixLLT().diagonal().cwiseAbs2();
  if ((pivots.array() <= rounding * block.diagonal().array()).any()) return false;
  blocks_.push_back({index, llt.solve(MatXX::Identity(block.rows(), block.cols()))});
  return true;
}

MatXX BlockDiagonal::Dense() const {
  MatXX D = MatXX::Zero(size_, size_);
  for (const auto& [index, inverse] : blocks_) D.block(index, index, inverse.rows(), inverse.cols()) = inverse;
  return D;
}

MatXX BlockDiagonal::LeftMultiply(const Eigen::Ref<const MatXX>& A) const {
  assert(A.cols() == size_ && "A·D: A must have as many columns as D has rows");
  MatXX AD = MatXX::Zero(A.rows(), size_);
  for (const auto& [index, inverse] : blocks_) {
    AD.middleCols(index, inverse.rows()).noalias() = A.middleCols(index, inverse.rows()) * inverse;
  }
  return AD;
}

MatXX BlockDiagonal::RightMultiply(const Eigen::Ref<const MatXX>& A) const {
  assert(A.rows() == size_ && "D·A: A must have as many rows as D has columns");
  MatXX DA = MatXX::Zero(size_, A.cols());
  for (const auto& [index, inverse] : blocks_) {
    DA.middleRows(index, inverse.rows()).noalias() = inverse * A.middleRows(index, inverse.rows());
  }
  return DA;
}

}  // namespace ch5
