#include "ch5_backend/apps/studies/matrices.h"

#include <Eigen/Eigenvalues>

namespace ch5 {

VecX Eigenvalues(const MatXX& H) {
  return Eigen::SelfAdjointEigenSolver<MatXX>(H, Eigen::EigenvaluesOnly).eigenvalues();
}

int NullDimension(const MatXX& H, double relative) {
  const VecX scale = H.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 1.0; });
  const VecX eigenvalues = Eigenvalues(scale.asDiagonal() * H * scale.asDiagonal());
  return static_cast<int>((eigenvalues.array() <= relative * eigenvalues.maxCoeff()).count());
}

}  // namespace ch5
