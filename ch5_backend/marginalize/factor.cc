/// FactorNormalEquations. Apart from square_root.cc, which the homework's given code calls: this is the answer of stages
/// 5 and 6.

#include "ch5_backend/linear/aligned_vector.h"
#include "ch5_backend/linear/pivot_rule.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/dense_kernels.h"

namespace ch5 {

// J = √Λ Uᵀ P, r₀ = −√Λ⁺ Uᵀ P⁻¹ b.  Leutenegger (2015), §4.3
SquareRootForm FactorNormalEquations(const MatXX& H, const VecX& b, const EigenvalueCutoff& cutoff) {
  const VecX p = ScalingFor(cutoff, H), p_inverse = p.cwiseInverse();
  const ScaledEigen eigen = DecomposeScaled(H, p_inverse, cutoff);
  const Eigen::Index rank = (eigen.S_sqrt.array() > 0.0).count();
  const auto U = eigen.U.rightCols(rank);
  SquareRootForm form;
  form.J = eigen.S_sqrt.tail(rank).asDiagonal() * U.transpose() * p.asDiagonal();
  form.r0 = -(eigen.S_pinv_sqrt.tail(rank).asDiagonal() * (U.transpose() * (p_inverse.asDiagonal() * b)));
  return form;
}

SquareRootForm FactorNormalEquations(const Eigen::Ref<const MatXX>& H, const Eigen::Ref<const VecX>& b,
                                     const VecX& scale) {
  constexpr int kPanel = 12;  // columns of Jᵀ before what remains of H is recomputed
  const int n = static_cast<int>(H.rows());
  ArrayVector p(n), p_inverse(n);
  p = scale.unaryExpr([](double H_ii) { return ScalingOf(H_ii); });
  p_inverse = p.cwiseInverse();
  ArrayVector memory(2 * n * n + 2 * kernels::kOverread);
  memory.setZero();
  Eigen::Map<MatXX> rest(memory.data(), n, n), Jt(memory.data() + n * n + kernels::kOverread, n, n);
  rest = p_inverse.asDiagonal() * H * p_inverse.asDiagonal();
  ArrayVector b_rest(n), diagonal(n), r0(n);
  b_rest = p_inverse.asDiagonal() * b;
  diagonal = rest.diagonal();
  int rank = 0, pivot = 0;
  const auto next = [&] { return rank < n && diagonal.maxCoeff(&pivot) > PivotRounding(n); };
  for (int first = 0; next(); first = rank) {
    for (; rank < first + kPanel && next(); ++rank) {
      auto J_k = Jt.col(rank);
      J_k.head(pivot) = rest.row(pivot).head(pivot).transpose();  // only the lower half has a meaning
      J_k.tail(n - pivot) = rest.col(pivot).tail(n - pivot);
      for (int k = first; k < rank; ++k) J_k -= Jt(pivot, k) * Jt.col(k);
      J_k /= std::sqrt(diagonal[pivot]);
      r0[rank] = -b_rest[pivot] / std::sqrt(diagonal[pivot]);
      b_rest += J_k * r0[rank];
      diagonal -= J_k.cwiseAbs2();
      diagonal[pivot] = 0.0;
    }
    kernels::SubtractProductAAt(n, rank - first, Jt.col(first).data(), n, rest.data(), n);
  }
  return {Jt.leftCols(rank).transpose() * p.asDiagonal(), r0.head(rank)};
}

}  // namespace ch5
