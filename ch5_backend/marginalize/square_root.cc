#include "ch5_backend/marginalize/square_root.h"

#include <Eigen/Eigenvalues>
#include <limits>

namespace ch5 {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// P⁻¹HP⁻¹ = U S Uᵀ, S ascending; what the cut counts as zero is zero in S_sqrt and in S_pinv_sqrt.
ScaledEigen Decompose(const MatXX& H, const VecX& p_inverse, const EigenCut& cut) {
  if (H.rows() == 0) return {MatXX(0, 0), VecX(0), VecX(0)};
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(p_inverse.asDiagonal() * H * p_inverse.asDiagonal());
  const VecX& S = eigen.eigenvalues();
  const double zero = std::max({0.0, cut.absolute, cut.relative * static_cast<double>(S.size()) * S.maxCoeff()});
  const auto kept = S.array() > zero;
  const VecX root = S.cwiseMax(zero).cwiseSqrt();
  return {eigen.eigenvectors(), kept.select(root, 0.0), kept.select(root.cwiseInverse(), 0.0)};
}

VecX ScalingFor(const EigenCut& cut, const MatXX& H) { return cut.scaled ? ScalingOf(H) : VecX::Ones(H.rows()); }

}  // namespace

EigenCut EigenCut::Okvis() { return {kEpsilon, 0.0, true}; }
EigenCut EigenCut::Vins() { return {0.0, 1e-8, false}; }

VecX ScalingOf(const MatXX& H) {
  return (H.diagonal().array() > 1e-9).select(H.diagonal().array().max(0.0).sqrt(), 1e-3);
}

ScaledEigen DecomposeScaled(const MatXX& H, const VecX& p_inverse) {
  return Decompose(H, p_inverse, EigenCut::Okvis());
}

SymmetricEigen DecomposeSymmetric(const MatXX& A) {
  if (A.rows() == 0) return {MatXX(0, 0), VecX(0)};
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(0.5 * (A + A.transpose()));
  return {eigen.eigenvectors(), eigen.eigenvalues()};
}

SquareRootForm FactorNormalEquations(const MatXX& H, const VecX& b, const EigenCut& cut) {
  const VecX p = ScalingFor(cut, H), p_inverse = p.cwiseInverse();
  const ScaledEigen eigen = Decompose(H, p_inverse, cut);
  const Eigen::Index rank = (eigen.S_sqrt.array() > 0.0).count();
  const auto U = eigen.U.rightCols(rank);
  SquareRootForm form;
  form.J = eigen.S_sqrt.tail(rank).asDiagonal() * U.transpose() * p.asDiagonal();
  form.r0 = -(eigen.S_pinv_sqrt.tail(rank).asDiagonal() * (U.transpose() * (p_inverse.asDiagonal() * b)));
  return form;
}

SquareRootForm FactorNormalEquations(const MatXX& H, const VecX& b) {
  const Eigen::Index n = H.rows();
  const VecX p = ScalingOf(H), p_inverse = p.cwiseInverse();
  MatXX H_rest = p_inverse.asDiagonal() * H * p_inverse.asDiagonal();
  VecX b_rest = p_inverse.asDiagonal() * b;
  MatXX Jt(n, n);
  VecX r0(n);
  Eigen::Index rank = 0, pivot = 0;
  for (; rank < n && H_rest.diagonal().maxCoeff(&pivot) > static_cast<double>(n) * kEpsilon; ++rank) {
    const double root = std::sqrt(H_rest(pivot, pivot));
    auto J_k = Jt.col(rank);
    J_k = H_rest.col(pivot) / root;
    r0[rank] = -b_rest[pivot] / root;
    H_rest.noalias() -= J_k * J_k.transpose();
    b_rest += J_k * r0[rank];
  }
  return {Jt.leftCols(rank).transpose() * p.asDiagonal(), r0.head(rank)};
}

MatXX PseudoInverseSquareRoot(const MatXX& A, const EigenCut& cut) {
  if (A.rows() == 1) {  // an inverse depth
    return MatXX::Constant(1, 1, A(0, 0) > cut.absolute ? 1.0 / std::sqrt(A(0, 0)) : 0.0);
  }
  const VecX p_inverse = ScalingFor(cut, A).cwiseInverse();
  const ScaledEigen eigen = Decompose(A, p_inverse, cut);
  return p_inverse.asDiagonal() * eigen.U * eigen.S_pinv_sqrt.asDiagonal();
}

}  // namespace ch5
