#pragma once
/// An edge's linear parts, whitened:  H = Σ J̃ᵀJ̃,  b = −Σ J̃ᵀr̃.
///
/// With W = FᵀF, s = rᵀWr and a loss ρ (Triggs 2000, §4.3; (1 − α)² = 1 + 2ρ''s/ρ'):
///   J̃ = √ρ' (I − α Fr (Fr)ᵀ/s) F J,   r̃ = √ρ'/(1 − α) F r
/// so that J̃ᵀJ̃ = JᵀW_ρJ and J̃ᵀr̃ = ρ'JᵀWr, with W_ρ as in graph/loss.h.

#include <cmath>

#include "ch5_backend/solve/block_structure.h"

namespace ch5 {

/// The scale of J̃ = scale·J and r̃ = scale·r where W = w I and the loss has no second-order term, else −1.
inline double ScalarWhitening(const Edge& edge) {
  const double w = edge.IsotropicInformation();
  if (!edge.GetLossFunction() || w < 0.0) return w < 0.0 ? -1.0 : std::sqrt(w);
  const RobustWeight robust = edge.GetRobustWeight();
  return robust.rank_one == 0.0 ? std::sqrt(w * robust.weight) : -1.0;
}

/// Writes the residual and the Jacobians of an edge, linearised at the present state, to their places in `linear`
/// (see BlockStructure). Padding is left alone. Safe to call for different edges at once.
void WriteLinearParts(const BlockStructure& structure, const EdgeRecord& record, double* linear);

/// M (n×n, row-major) with J̃ = M J, and r̃ (n×1), at the edge's last residual.
void WhitenFully(const Edge& edge, const RobustWeight& robust, double* M, double* r_tilde);

/// F (n×n, row-major) with W = FᵀF for a symmetric positive semi-definite W: Cholesky with diagonal pivoting, which
/// ends where the rest is rounding; F's last rows are zero then. Golub & Van Loan, "Matrix Computations", §4.2.8.
void FactorPsd(const double* W, int n, double* F);

}  // namespace ch5
