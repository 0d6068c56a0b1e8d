#include "ch5_backend/linear/selected_inverse.h"

#include <algorithm>

namespace ch5 {

SelectedInverse::SelectedInverse(const SparseCholesky& cholesky)
    : plan_(cholesky.Plan()), front_of_(plan_.FrontOfEachBlock()) {
  rows_below_.resize(plan_.fronts.size());
  Z_.resize(plan_.fronts.size());
  for (size_t f = 0; f < plan_.fronts.size(); ++f) {
    int row = plan_.fronts[f].pivots;
    for (const int block : plan_.fronts[f].below) {
      rows_below_[f].push_back(row);
      row += plan_.Dim(block);
    }
  }
  for (size_t f = plan_.fronts.size(); f-- > 0;) InvertFront(f, cholesky);
}

void SelectedInverse::InvertFront(size_t f, const SparseCholesky& cholesky) {
  const Front& front = plan_.fronts[f];
  const int k = front.pivots, r = front.rows_below;
  const auto columns = cholesky.Columns(static_cast<int>(f));
  const auto L_11 = columns.topRows(k).triangularView<Eigen::Lower>();
  const MatXX L_11_inverse = L_11.solve(MatXX::Identity(k, k));
  MatXX& Z = Z_[f];
  Z.resize(k + r, k);
  Z.topRows(k).noalias() = L_11_inverse.transpose() * L_11_inverse;
  if (r == 0) return;  // a root

  MatXX Z_bb(r, r);
  for (size_t a = 0; a < front.below.size(); ++a) {
    for (size_t b = 0; b <= a; ++b) {
      const int i = front.below[a], j = front.below[b];
      const auto Z_ij = *Find(i, j);
      const int row = rows_below_[f][a] - k, column = rows_below_[f][b] - k;
      Z_bb.block(row, column, plan_.Dim(i), plan_.Dim(j)) = Z_ij;
      Z_bb.block(column, row, plan_.Dim(j), plan_.Dim(i)) = Z_ij.transpose();
    }
  }
  const MatXX Y = L_11.transpose().solve(columns.bottomRows(r).transpose()).transpose();
  Z.bottomRows(r).noalias() = -Z_bb * Y;
  Z.topRows(k).noalias() -= Y.transpose() * Z.bottomRows(r);
}

int SelectedInverse::RowInFront(size_t f, int block) const {
  const Front& front = plan_.fronts[f];
  if (block < front.last) return plan_.offset[block] - plan_.offset[front.first];
  const auto it = std::lower_bound(front.below.begin(), front.below.end(), block);
  return it != front.below.end() && *it == block ? rows_below_[f][static_cast<size_t>(it - front.below.begin())] : -1;
}

// Both counted in elimination order.
std::optional<Eigen::Block<const MatXX>> SelectedInverse::Find(int later, int earlier) const {
  const size_t f = static_cast<size_t>(front_of_[earlier]);
  const int row = RowInFront(f, later);
  if (row < 0) return std::nullopt;
  return Z_[f].block(row, RowInFront(f, earlier), plan_.Dim(later), plan_.Dim(earlier));
}

std::optional<MatXX> SelectedInverse::Block(int i, int j) const {
  const int a = plan_.position[i], b = plan_.position[j];
  const auto found = Find(std::max(a, b), std::min(a, b));
  if (!found) return std::nullopt;
  return a >= b ? MatXX(*found) : MatXX(found->transpose());
}

}  // namespace ch5
