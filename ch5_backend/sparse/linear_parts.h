#pragma once
/// An edge's linear parts, whitened:  H = Σ J̃ᵀJ̃,  b = −Σ J̃ᵀr̃.
///
/// With W = FᵀF, s = rᵀWr and a loss ρ (Triggs 2000, §4.3; (1 − α)² = 1 + 2ρ''s/ρ'):
///   J̃ = √ρ' (I − α Fr (Fr)ᵀ/s) F J,   r̃ = √ρ'/(1 − α) F r
/// so that J̃ᵀJ̃ = JᵀW_ρJ and J̃ᵀr̃ = ρ'JᵀWr, with W_ρ as in graph/loss.h.

#include <cmath>

#include "ch5_backend/sparse/block_structure.h"

namespace ch5 {

/// The factor F of the edges' W, made anew only where W has changed.
class InformationFactors {
 public:
  /// Takes memory for the edges from `first_edge` on whose W is not a multiple of the identity.
  void Prepare(const BlockStructure& structure, int first_edge);
  /// F (n×n, row-major) of edge e. Safe to call for different edges at once.
  const double* Of(const BlockStructure& structure, int e);

 private:
  struct Entry {
    int begin = -1, version = -1;
  };
  int first_edge_ = 0;
  std::vector<Entry> entries_;
  std::vector<double> values_;
};

/// ρ' and ρ'' of a loss (or none) at s, as in graph/loss.h.
inline RobustWeight WeightAt(const LossFunction* loss, double s) {
  return loss ? CorrectLoss(loss->EvaluateSlopes(s), s, loss->Correction()) : RobustWeight{1.0, 0.0};
}

/// 1 − α.
inline double Shrink(const RobustWeight& robust, double s) {
  return robust.rank_one != 0.0 && s > 0.0 ? std::sqrt(1.0 + robust.rank_one * s / robust.weight) : 1.0;
}

/// The scale of J̃ = scale·J and r̃ = scale·r where W = w I and the loss has no second-order term at the edge's last
/// residual, else −1.
inline double ScalarWhitening(const Edge& edge) {
  const double w = edge.IsotropicInformation();
  if (!edge.GetLossFunction() || w < 0.0) return w < 0.0 ? -1.0 : std::sqrt(w);
  const RobustWeight robust = edge.GetRobustWeight();
  return robust.rank_one == 0.0 ? std::sqrt(w * robust.weight) : -1.0;
}

/// r̃ and M with J̃ = M J for two rows and W = w I: the most frequent kind of edge.
struct WhiteRows {
  double r[2];
  double M[2][2];  ///< symmetric

  WhiteRows(double w, const LossFunction* loss, const double* residual)
      : WhiteRows(w, WeightAt(loss, w * (residual[0] * residual[0] + residual[1] * residual[1])), residual) {}
  WhiteRows(double w, const RobustWeight& robust, const double* residual) {
    const double square = residual[0] * residual[0] + residual[1] * residual[1];
    const double root = std::sqrt(w * robust.weight), shrink = Shrink(robust, w * square);
    const double bend = shrink == 1.0 ? 0.0 : root * (1.0 - shrink) / square;
    for (int i = 0; i < 2; ++i) {
      r[i] = root / shrink * residual[i];
      for (int j = 0; j < 2; ++j) M[i][j] = (i == j ? root : 0.0) - bend * residual[i] * residual[j];
    }
  }
};

/// The normal equations of edge e (see block_structure.h) at its last Linearize, negative: C = −[J̃ r̃]ᵀ[J̃ r̃], of
/// which the lower half is meant, column-major without padding.
void EdgeProducts(const BlockStructure& structure, int e, InformationFactors* factors, double* C);

/// Linearises edge e first, or asks it for its products where it has them (Edge::ProductsInto).
void LinearizedProducts(const BlockStructure& structure, int e, InformationFactors* factors, double* C);
/// The same of one edge: C's columns are these of the edge's own products, the residual's among them.
/// @return false if the edge has none
bool TakeProducts(Edge* edge, const std::vector<int>& columns, double* C);

/// M (n×n, row-major) with J̃ = M J, and r̃ (n×1), at the edge's last residual; F is the factor of its W.
void WhitenFully(const Edge& edge, const double* F, double* M, double* r_tilde);
/// The same, with W factored for this once.
void WhitenFully(const Edge& edge, const RobustWeight& robust, double* M, double* r_tilde);

/// F (n×n, row-major) with W = FᵀF for a symmetric positive semi-definite W: Cholesky with diagonal pivoting, which
/// ends where the rest is rounding; F's last rows are zero then. Golub & Van Loan, "Matrix Computations", §4.2.8.
void FactorPsd(const double* W, int n, double* F);

}  // namespace ch5
