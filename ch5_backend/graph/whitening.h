#pragma once
/// Whitening an edge:  r̃ and J̃ = M J with  JᵀW_ρJ = J̃ᵀJ̃  and  ρ'JᵀWr = J̃ᵀr̃,  so that  H = Σ J̃ᵀJ̃,  b = −Σ J̃ᵀr̃.
///
/// With W = FᵀF, s = rᵀWr and a loss ρ (Triggs 2000, §4.3; (1 − α)² = 1 + 2ρ''s/ρ'):
///   J̃ = √ρ' (I − α Fr (Fr)ᵀ/s) F J,   r̃ = √ρ'/(1 − α) F r;   W_ρ as in graph/loss.h
///
/// Two cases of this one formula: two rows with W = w I (TwoRowWhitening), and any (Whiten).

#include <cmath>

#include "ch5_backend/graph/edge.h"

namespace ch5 {

/// ρ' and ρ'' of a loss (or none) at s, as in graph/loss.h.
inline RobustWeight WeightAt(const LossFunction* loss, double s) {
  return loss ? CorrectLoss(loss->EvaluateSlopes(s), s, loss->Correction()) : RobustWeight{1.0, 0.0};
}

/// 1 − α.
inline double Shrink(const RobustWeight& robust, double s) {
  return robust.rank_one != 0.0 && s > 0.0 ? std::sqrt(1.0 + robust.rank_one * s / robust.weight) : 1.0;
}

/// r̃ and M with J̃ = M J for two rows and W = w I: the most frequent kind of edge.
struct TwoRowWhitening {
  double r[2];
  double M[2][2];  ///< symmetric

  TwoRowWhitening(double w, const LossFunction* loss, const double* residual)
      : TwoRowWhitening(w, WeightAt(loss, w * (residual[0] * residual[0] + residual[1] * residual[1])), residual) {}
  TwoRowWhitening(double w, const RobustWeight& robust, const double* residual) {
    const double square = residual[0] * residual[0] + residual[1] * residual[1];
    const double root = std::sqrt(w * robust.weight), shrink = Shrink(robust, w * square);
    const double bend = shrink == 1.0 ? 0.0 : root * (1.0 - shrink) / square;
    for (int i = 0; i < 2; ++i) {
      r[i] = root / shrink * residual[i];
      for (int j = 0; j < 2; ++j) M[i][j] = (i == j ? root : 0.0) - bend * residual[i] * residual[j];
    }
  }
};

/// M (n×n, row-major) and r̃ (n×1) at the edge's last residual.
void Whiten(const Edge& edge, double* M, double* r_tilde);

/// F (n×n, row-major) with W = FᵀF for a symmetric positive semi-definite W: Cholesky with diagonal pivoting, which
/// ends where the rest is rounding; F's last rows are zero then. Golub & Van Loan, "Matrix Computations", §4.2.8.
void FactorPsd(const double* W, int n, double* F);

}  // namespace ch5
