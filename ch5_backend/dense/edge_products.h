#pragma once
/// What one edge adds to the dense H and b: small products, in memory that is kept from edge to edge.

#include <vector>

#include "ch5_backend/graph/edge.h"

namespace ch5 {

class EdgeProducts {
 public:
  /// Multiplies out the edge's last residual and Jacobians, for all of its vertices that have rows in H.
  void Compute(const Edge& edge);

  /// J_iᵀ W_ρ J_j, dim_i × dim_j, for i ≤ j; W_ρ is the loss function's robust form of W.
  const MatXX& JtWJ(size_t i, size_t j) const { return blocks_[i * num_vertices_ + j]; }
  /// ρ' J_iᵀ W r, dim_i × 1.
  const VecX& JtWr(size_t i) const { return gradients_[i]; }

 private:
  size_t num_vertices_ = 0;
  MatXX W_rho_, WJ_;
  VecX Wr_;
  std::vector<MatXX> blocks_;
  std::vector<VecX> gradients_;
};

}  // namespace ch5
