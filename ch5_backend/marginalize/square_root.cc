#include "ch5_backend/marginalize/square_root.h"

#include <Eigen/Eigenvalues>
#include <limits>

#include "ch5_backend/math/dense_kernels.h"

namespace ch5 {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// P⁻¹HP⁻¹ = U S Uᵀ, S ascending; eigenvalues below the cutoff are zero in S_sqrt and in S_pinv_sqrt.
ScaledEigen Decompose(const MatXX& H, const VecX& p_inverse, const EigenvalueCutoff& cutoff) {
  if (H.rows() == 0) return {MatXX(0, 0), VecX(0), VecX(0)};
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(p_inverse.asDiagonal() * H * p_inverse.asDiagonal());
  const VecX& S = eigen.eigenvalues();
  const double zero = std::max({0.0, cutoff.absolute, cutoff.relative * static_cast<double>(S.size()) * S.maxCoeff()});
  const auto kept = S.array() > zero;
  const VecX root = S.cwiseMax(zero).cwiseSqrt();
  return {eigen.eigenvectors(), kept.select(root, 0.0), kept.select(root.cwiseInverse(), 0.0)};
}

VecX ScalingFor(const EigenvalueCutoff& cutoff, const MatXX& H) {
  return cutoff.scaled ? ScalingOf(H) : VecX::Ones(H.rows());
}

}  // namespace

EigenvalueCutoff EigenvalueCutoff::Okvis() { return {kEpsilon, 0.0, true}; }
EigenvalueCutoff EigenvalueCutoff::Vins() { return {0.0, 1e-8, false}; }

VecX ScalingOf(const MatXX& H) {
  return (H.diagonal().array() > 1e-9).select(H.diagonal().array().max(0.0).sqrt(), 1e-3);
}

ScaledEigen DecomposeScaled(const MatXX& H, const VecX& p_inverse) {
  return Decompose(H, p_inverse, EigenvalueCutoff::Okvis());
}

SymmetricEigen DecomposeSymmetric(const MatXX& A) {
  if (A.rows() == 0) return {MatXX(0, 0), VecX(0)};
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(0.5 * (A + A.transpose()));
  return {eigen.eigenvectors(), eigen.eigenvalues()};
}

// J = √Λ Uᵀ P, r₀ = −√Λ⁺ Uᵀ P⁻¹ b.  Leutenegger (2015), §4.3
SquareRootForm FactorNormalEquations(const MatXX& H, const VecX& b, const EigenvalueCutoff& cutoff) {
  const VecX p = ScalingFor(cutoff, H), p_inverse = p.cwiseInverse();
  const ScaledEigen eigen = Decompose(H, p_inverse, cutoff);
  const Eigen::Index rank = (eigen.S_sqrt.array() > 0.0).count();
  const auto U = eigen.U.rightCols(rank);
  SquareRootForm form;
  form.J = eigen.S_sqrt.tail(rank).asDiagonal() * U.transpose() * p.asDiagonal();
  form.r0 = -(eigen.S_pinv_sqrt.tail(rank).asDiagonal() * (U.transpose() * (p_inverse.asDiagonal() * b)));
  return form;
}

SquareRootForm FactorNormalEquations(const MatXX& H, const VecX& b) {
  constexpr int kPanel = 12;  // columns of Jᵀ before what remains of H is computed anew
  const int n = static_cast<int>(H.rows());
  const VecX p = ScalingOf(H), p_inverse = p.cwiseInverse();
  VecX memory = VecX::Zero(2 * n * n + 2 * kernels::kOverread);
  Eigen::Map<MatXX> rest(memory.data(), n, n), Jt(memory.data() + n * n + kernels::kOverread, n, n);
  rest = p_inverse.asDiagonal() * H * p_inverse.asDiagonal();
  VecX b_rest = p_inverse.asDiagonal() * b, diagonal = rest.diagonal(), r0(n);
  int rank = 0, pivot = 0;
  const auto next = [&] { return rank < n && diagonal.maxCoeff(&pivot) > n * kEpsilon; };
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

MatXX PseudoInverseSquareRoot(const MatXX& A, const EigenvalueCutoff& cutoff) {
  if (A.rows() == 1) {  // an inverse depth
    return MatXX::Constant(1, 1, A(0, 0) > cutoff.absolute ? 1.0 / std::sqrt(A(0, 0)) : 0.0);
  }
  const VecX p_inverse = ScalingFor(cutoff, A).cwiseInverse();
  const ScaledEigen eigen = Decompose(A, p_inverse, cutoff);
  return p_inverse.asDiagonal() * eigen.U * eigen.S_pinv_sqrt.asDiagonal();
}

}  // namespace ch5
