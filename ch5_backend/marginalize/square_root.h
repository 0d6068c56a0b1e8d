#pragma once
/// From normal equations back to a residual:  H = JᵀJ,  b = −Jᵀr₀.

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// Which eigenvalues of H count as zero. A relative cutoff does not depend on the units of the states, an absolute one
/// does; the cutoffs of both systems of the course are given.
struct EigenvalueCutoff {
  double relative = 0.0;  ///< times n·λ_max
  double absolute = 0.0;
  bool scaled = false;  ///< decompose P⁻¹HP⁻¹, P = √diag(H), instead of H

  static EigenvalueCutoff Okvis();  ///< relative ε, scaled (MarginalizationError)
  static EigenvalueCutoff Vins();   ///< absolute 1e-8 (MarginalizationInfo)
};

struct SquareRootForm {
  MatXX J;  ///< rank×n
  VecX r0;  ///< rank×1
};

/// J = (P U S^½)ᵀ and r₀ = −S^-½ Uᵀ P⁻¹ b over the eigenvalues S of P⁻¹HP⁻¹ = U S Uᵀ above the cutoff.
/// @param H  n×n symmetric positive semi-definite;  @param b  n×1, in the range of H
SquareRootForm FactorNormalEquations(const MatXX& H, const VecX& b, const EigenvalueCutoff& cutoff);

/// The same H and b from another J, a permuted triangle: Cholesky of P⁻¹HP⁻¹, P = √diag(scale), with diagonal pivoting,
/// which stops where only rounding errors remain (linear/pivot_rule.h). It takes a tenth of the time of an
/// eigendecomposition.
/// @param scale  n×1, the diagonal of H, or of that from which H is what an elimination has left: rounding is as large as
///               a part of that. Taken for knowledge, rounding of a free gauge becomes r₀ = b/√rounding without bound
/// Source: Golub & Van Loan, "Matrix Computations", §4.2.8.
SquareRootForm FactorNormalEquations(const Eigen::Ref<const MatXX>& H, const Eigen::Ref<const VecX>& b,
                                     const VecX& scale);

/// p_i = √H_ii where H_ii > 1e-9, else 1e-3 (OKVIS): what makes the diagonal of P⁻¹HP⁻¹ one.
inline double ScalingOf(double H_ii) { return H_ii > 1e-9 ? std::sqrt(H_ii) : 1e-3; }
inline VecX ScalingOf(const VecX& diagonal) {
  return diagonal.unaryExpr([](double H_ii) { return ScalingOf(H_ii); });
}
inline VecX ScalingOf(const MatXX& H) { return ScalingOf(VecX(H.diagonal())); }
/// The same where the cutoff asks for it, else ones.
VecX ScalingFor(const EigenvalueCutoff& cutoff, const MatXX& H);

/// P⁻¹HP⁻¹ = U S Uᵀ, S ascending: eigenvalues up to the cutoff, OKVIS's ε·n·λ_max, are zero in S_sqrt and in S_pinv_sqrt.
struct ScaledEigen {
  MatXX U;           ///< n×n
  VecX S_sqrt;       ///< n×1
  VecX S_pinv_sqrt;  ///< n×1
};
/// @param H  n×n symmetric;  @param p_inverse  1/p, n×1, see ScalingOf
ScaledEigen DecomposeScaled(const MatXX& H, const VecX& p_inverse,
                            const EigenvalueCutoff& cutoff = EigenvalueCutoff::Okvis());

/// A = V S Vᵀ, S ascending.  @param A  n×n symmetric up to rounding; ½(A + Aᵀ) is decomposed
struct SymmetricEigen {
  MatXX V;  ///< n×n
  VecX S;   ///< n×1
};
SymmetricEigen DecomposeSymmetric(const MatXX& A);

/// M with A M Mᵀ A = A, so that H_km M (H_km M)ᵀ is what a Schur complement subtracts. M Mᵀ = A⁻¹ where A has full rank,
/// and A⁺ for a cutoff without scaling.
/// @param A  n×n symmetric positive semi-definite
MatXX PseudoInverseSquareRoot(const MatXX& A, const EigenvalueCutoff& cutoff = EigenvalueCutoff::Okvis());

}  // namespace ch5
