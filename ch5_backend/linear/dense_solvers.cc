#include "ch5_backend/linear/dense_solvers.h"

#include <Eigen/Cholesky>
#include <limits>

namespace ch5 {

bool SolveLdlt(const MatXX& A, const VecX& b, VecX* x) {
  const Eigen::LDLT<MatXX> ldlt(A);
  if (ldlt.info() != Eigen::Success) return false;
  const auto pivots = ldlt.vectorD();
  const double rounding = static_cast<double>(A.rows()) * std::numeric_limits<double>::epsilon();
  if (A.rows() > 0 && pivots.minCoeff() <= rounding * pivots.cwiseAbs().maxCoeff()) {
    // A badly scaled matrix may be definite all the same: judge it after scaling its diagonal to one.
    const VecX scale = A.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<MatXX> scaled(scale.asDiagonal() * A * scale.asDiagonal());
    if (scaled.vectorD().minCoeff() <= rounding) return false;
    *x = scale.asDiagonal() * scaled.solve(scale.asDiagonal() * b);
    return x->allFinite();
  }
  *x = ldlt.solve(b);
  return x->allFinite();
}

bool SolvePcg(const MatXX& A, const VecX& b, int max_iterations, double tolerance, VecX* x) {
  const VecX M_inverse = A.diagonal().cwiseInverse();
  if (A.rows() > 0 && !(A.diagonal().minCoeff() > 0.0)) return false;
  *x = VecX::Zero(b.size());
  VecX r = b;
  VecX z = M_inverse.asDiagonal() * r;
  VecX p = z;
  double rz = r.dot(z);
  const double goal = tolerance * b.norm();
  for (int i = 0; i < max_iterations && r.norm() > goal; ++i) {
    const VecX Ap = A * p;
    const double curvature = p.dot(Ap);
    if (!(curvature > 0.0)) return false;
    const double alpha = rz / curvature;
    *x += alpha * p;
    r -= alpha * Ap;
    z = M_inverse.asDiagonal() * r;
    const double rz_new = r.dot(z);
    p = z + (rz_new / rz) * p;
    rz = rz_new;
  }
  return x->allFinite();
}

}  // namespace ch5
