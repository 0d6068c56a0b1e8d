#include "ch5_backend/marginalize/square_root.h"

#include <Eigen/Eigenvalues>
#include <limits>

namespace ch5 {

EigenvalueCutoff EigenvalueCutoff::Okvis() { return {std::numeric_limits<double>::epsilon(), 0.0, true}; }
EigenvalueCutoff EigenvalueCutoff::Vins() { return {0.0, 1e-8, false}; }

VecX ScalingFor(const EigenvalueCutoff& cutoff, const MatXX& H) {
  return cutoff.scaled ? ScalingOf(H) : VecX::Ones(H.rows());
}

ScaledEigen DecomposeScaled(const MatXX& H, const VecX& p_inverse, const EigenvalueCutoff& cutoff) {
  if (H.rows() == 0) return {MatXX(0, 0), VecX(0), VecX(0)};
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(p_inverse.asDiagonal() * H * p_inverse.asDiagonal());
  const VecX& S = eigen.eigenvalues();
  const double zero = std::max({0.0, cutoff.absolute, cutoff.relative * static_cast<double>(S.size()) * S.maxCoeff()});
  const auto kept = S.array() > zero;
  const VecX root = S.cwiseMax(zero).cwiseSqrt();
  return {eigen.eigenvectors(), kept.select(root, 0.0), kept.select(root.cwiseInverse(), 0.0)};
}

SymmetricEigen DecomposeSymmetric(const MatXX& A) {
  if (A.rows() == 0) return {MatXX(0, 0), VecX(0)};
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(0.5 * (A + A.transpose()));
  return {eigen.eigenvectors(), eigen.eigenvalues()};
}

MatXX PseudoInverseSquareRoot(const MatXX& A, const EigenvalueCutoff& cutoff) {
  if (A.rows() == 1) {  // an inverse depth
    return MatXX::Constant(1, 1, A(0, 0) > cutoff.absolute ? 1.0 / std::sqrt(A(0, 0)) : 0.0);
  }
  const VecX p_inverse = ScalingFor(cutoff, A).cwiseInverse();
  const ScaledEigen eigen = DecomposeScaled(A, p_inverse, cutoff);
  return p_inverse.asDiagonal() * eigen.U * eigen.S_pinv_sqrt.asDiagonal();
}

}  // namespace ch5
