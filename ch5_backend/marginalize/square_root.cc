#include "ch5_backend/marginalize/square_root.h"

#include <Eigen/Eigenvalues>
#include <limits>

namespace ch5 {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

}  // namespace

EigenCut EigenCut::Okvis() { return {kEpsilon, 0.0, true}; }
EigenCut EigenCut::Vins() { return {0.0, 1e-8, false}; }

VecX ScalingOf(const MatXX& H) {
  return (H.diagonal().array() > 1e-9).select(H.diagonal().array().max(0.0).sqrt(), 1e-3);
}

EigenPairs DecomposeSymmetric(const MatXX& A) {
  if (A.rows() == 0) return {MatXX(0, 0), VecX(0)};
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(A);
  return {eigen.eigenvectors(), eigen.eigenvalues()};
}

ScaledEigen DecomposeScaled(const MatXX& H, const VecX& p_inverse) {
  if (H.rows() == 0) return {MatXX(0, 0), VecX(0), VecX(0)};
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(p_inverse.asDiagonal() * H * p_inverse.asDiagonal());
  const VecX& S = eigen.eigenvalues();
  const double zero = std::max(0.0, static_cast<double>(H.rows()) * kEpsilon * S.maxCoeff());
  const auto kept = S.array() > zero;
  const VecX root = S.cwiseMax(zero).cwiseSqrt();
  return {eigen.eigenvectors(), kept.select(root, 0.0), kept.select(root.cwiseInverse(), 0.0)};
}

SquareRootForm FactorNormalEquations(const MatXX& H, const VecX& b, const EigenCut& cut) {
  const Eigen::Index n = H.rows();
  if (n == 0) return {MatXX(0, 0), VecX(0)};
  const VecX p = cut.scaled ? ScalingOf(H) : VecX::Ones(n);
  const VecX p_inverse = p.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(p_inverse.asDiagonal() * H * p_inverse.asDiagonal());
  const VecX& S = eigen.eigenvalues();  // ascending
  const double zero = std::max(cut.absolute, cut.relative * static_cast<double>(n) * S[n - 1]);
  const Eigen::Index rank = (S.array() > zero).count();
  const VecX root = S.tail(rank).cwiseSqrt();
  const auto U = eigen.eigenvectors().rightCols(rank);
  SquareRootForm form;
  form.J = root.asDiagonal() * U.transpose() * p.asDiagonal();
  form.r0 = -(root.cwiseInverse().asDiagonal() * (U.transpose() * (p_inverse.asDiagonal() * b)));
  return form;
}

MatXX PseudoInverseSquareRoot(const MatXX& A) {
  if (A.rows() == 1) {  // an inverse depth
    return MatXX::Constant(1, 1, A(0, 0) > 0.0 ? 1.0 / std::sqrt(A(0, 0)) : 0.0);
  }
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(A);
  const VecX& S = eigen.eigenvalues();
  const double zero = std::max(0.0, static_cast<double>(A.rows()) * kEpsilon * S.maxCoeff());
  const VecX root = S.cwiseMax(zero).cwiseSqrt().cwiseInverse();
  return eigen.eigenvectors() * (S.array() > zero).select(root, 0.0).asDiagonal();
}

}  // namespace ch5
