#include "ch5_backend/math/psd.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace ch5 {

std::string WhyNotPositiveSemiDefinite(const MatXX& A) {
  constexpr double kRelativeTolerance = 1e-9;
  // Most matrices are valid: the stream, which costs more than the checks, is made only for those that are not.
  const auto say = [](const auto&... words) {
    std::ostringstream why;
    (why << ... << words);
    return why.str();
  };
  const auto entry = [&](const char* fault, int i, int j) { return say(fault, ": (", i, ", ", j, ") = ", A(i, j)); };
  if (A.rows() != A.cols()) return say("is not square: ", A.rows(), "x", A.cols());
  for (int i = 0; i < A.rows(); ++i) {
    for (int j = 0; j < A.cols(); ++j) {
      if (!std::isfinite(A(i, j))) return entry("has an entry that is not finite", i, j);
    }
  }
  const double scale = A.size() == 0 ? 0.0 : A.cwiseAbs().maxCoeff();
  for (int i = 0; i < A.rows(); ++i) {
    for (int j = 0; j < i; ++j) {
      if (std::abs(A(i, j) - A(j, i)) <= kRelativeTolerance * scale) continue;
      return say("is not symmetric: (", i, ", ", j, ") = ", A(i, j), " but (", j, ", ", i, ") = ", A(j, i));
    }
  }
  if (A.isDiagonal(0.0)) {
    for (int i = 0; i < A.rows(); ++i) {
      if (A(i, i) < 0.0) return entry("is not positive semi-definite", i, i);
    }
    return "";
  }
  if (Eigen::LLT<MatXX>(A).info() == Eigen::Success) return "";  // as most are; eigenvalues cost ten times as much
  const double smallest = Eigen::SelfAdjointEigenSolver<MatXX>(A, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (smallest >= -kRelativeTolerance * scale) return "";
  return say("is not positive semi-definite: its smallest eigenvalue is ", smallest);
}

MatXX ProjectToPsd(const MatXX& A) {
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(A);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() * eigen.eigenvectors().transpose();
}

MatXX PseudoInversePsd(const MatXX& A) {
  if (A.rows() == 0) return A;
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(A);
  const VecX& S = eigen.eigenvalues();
  const double cut = static_cast<double>(A.rows()) * std::numeric_limits<double>::epsilon() * S.maxCoeff();
  const VecX S_inverse = (S.array() > cut).select(S.array().inverse(), 0.0);
  return eigen.eigenvectors() * S_inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

MatXX PseudoInversePsd(const MatXX& A, int nullity) {
  const Eigen::SelfAdjointEigenSolver<MatXX> eigen(A);  // eigenvalues ascend
  const Eigen::Index rank = A.rows() - nullity;
  if (eigen.info() != Eigen::Success || rank < 0 || !(eigen.eigenvalues().tail(rank).array() > 0.0).all()) {
    throw std::invalid_argument("PseudoInversePsd: the matrix has more than " + std::to_string(nullity) +
                                " eigenvalues that are not positive");
  }
  const MatXX vectors = eigen.eigenvectors().rightCols(rank);
  return vectors * eigen.eigenvalues().tail(rank).cwiseInverse().asDiagonal() * vectors.transpose();
}

MatXX InverseOfCovariance(const MatXX& covariance, const std::string& of) {
  const std::string fault = WhyNotPositiveSemiDefinite(covariance);
  if (!fault.empty()) throw std::invalid_argument(of + ": the covariance " + fault);
  const Eigen::LLT<MatXX> factor(covariance);
  if (factor.info() != Eigen::Success) throw std::invalid_argument(of + ": the covariance is singular");
  return factor.solve(MatXX::Identity(covariance.rows(), covariance.cols()));
}

}  // namespace ch5
