#pragma once
/// Blocks of A⁻¹ from the Cholesky factor of a sparse A, at about the cost of the factorization.
///
/// Where L has a number, A⁻¹ = Z needs no other numbers of Z than those where L has one. With p the pivots of a front
/// and b its rows below (elimination_plan.h), parents first:
///
///   Y    = L_21 L_11⁻¹
///   Z_bp = −Z_bb Y                          Z_bb is known: an ancestor has each of its blocks
///   Z_pp = L_11⁻ᵀ L_11⁻¹ − Yᵀ Z_bp
///
/// Source: Takahashi, Fagan & Chin, "Formation of a sparse bus impedance matrix", 1973; in blocks here.

#include <optional>
#include <vector>

#include "ch5_backend/linear/sparse_cholesky.h"

namespace ch5 {

class SelectedInverse {
 public:
  /// @param cholesky  its last factorization must have succeeded; it is not needed any more afterwards
  explicit SelectedInverse(const SparseCholesky& cholesky);

  /// Block (i, j) of A⁻¹, numbered as in A; nothing if L has no such block. Every block that A has, L has too.
  std::optional<MatXX> Block(int i, int j) const;

 private:
  void InvertFront(size_t f, const SparseCholesky& cholesky);
  int RowInFront(size_t f, int block) const;
  std::optional<Eigen::Block<const MatXX>> Find(int later, int earlier) const;

  EliminationPlan plan_;
  Array<int> front_of_;                       // the front that eliminates a block
  std::vector<std::vector<int>> rows_below_;  // of each front: the row of each block below
  std::vector<MatXX> Z_;                      // of each front: [Z_pp; Z_bp]
};

}  // namespace ch5
