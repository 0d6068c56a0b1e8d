#include "ch5_backend/math/psd.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <sstream>

namespace ch5 {

std::string WhyNotPositiveSemiDefinite(const MatXX& A) {
  constexpr double kRelativeTolerance = 1e-9;
  std::ostringstream why;
  if (A.rows() != A.cols()) {
    why << "is not square: " << A.rows() << "x" << A.cols();
    return why.str();
  }
  for (int i = 0; i < A.rows(); ++i) {
    for (int j = 0; j < A.cols(); ++j) {
      if (!std::isfinite(A(i, j))) {
        why << "has an entry that is not finite: (" << i << ", " << j << ") = " << A(i, j);
        return why.str();
      }
    }
  }
  const double scale = A.size() == 0 ? 0.0 : A.cwiseAbs().maxCoeff();
  for (int i = 0; i < A.rows(); ++i) {
    for (int j = 0; j < i; ++j) {
      if (std::abs(A(i, j) - A(j, i)) > kRelativeTolerance * scale) {
        why << "is not symmetric: (" << i << ", " << j << ") = " << A(i, j) << " but (" << j << ", " << i
            << ") = " << A(j, i);
        return why.str();
      }
    }
  }
  if (A.isDiagonal(0.0)) {
    for (int i = 0; i < A.rows(); ++i) {
      if (A(i, i) < 0.0) {
        why << "is not positive semi-definite: (" << i << ", " << i << ") = " << A(i, i);
        return why.str();
      }
    }
    return "";
  }
  const double smallest = Eigen::SelfAdjointEigenSolver<MatXX>(A, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (smallest < -kRelativeTolerance * scale) {
    why << "is not positive semi-definite: its smallest eigenvalue is " << smallest;
    return why.str();
  }
  return "";
}

MatXX PseudoInversePsd(const MatXX& A) {
  if (A.rows() == 0) return A;
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(A);
  const VecX& S = eigen.eigenvalues();
  const double cut = static_cast<double>(A.rows()) * std::numeric_limits<double>::epsilon() * S.maxCoeff();
  const VecX S_inverse = (S.array() > cut).select(S.array().inverse(), 0.0);
  return eigen.eigenvectors() * S_inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace ch5
