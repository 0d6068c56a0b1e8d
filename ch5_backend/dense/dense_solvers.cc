#include "ch5_backend/dense/dense_solvers.h"

#include <Eigen/Cholesky>

#include "ch5_backend/linear/conjugate_gradients.h"
#include "ch5_backend/linear/pivot_rule.h"

namespace ch5 {

bool SolveLdlt(const MatXX& A, const VecX& b, VecX* x) {
  const Eigen::LDLT<MatXX> ldlt(A);
  if (ldlt.info() != Eigen::Success) return false;
  const VecX scale = ldlt.transpositionsP() * A.diagonal();  // in the order of the pivots
  const double rounding = PivotRounding(static_cast<int>(A.rows()));
  if (!(ldlt.vectorD().array() > rounding * scale.array()).all()) return false;
  *x = ldlt.solve(b);
  return x->allFinite();
}

bool SolvePcg(const MatXX& A, const VecX& b, int max_iterations, double tolerance, VecX* x) {
  if (!(A.diagonal().array() > 0.0).all()) return false;
  const VecX M_inverse = A.diagonal().cwiseInverse();
  const auto multiply = [&](const VecX& v, VecX* Av) { Av->noalias() = A * v; };
  const auto precondition = [&](const VecX& r, VecX* z) { *z = M_inverse.asDiagonal() * r; };
  const double goal = tolerance * b.norm();
  const auto is_enough = [&](const LinearIterate& iterate) { return iterate.r.norm() <= goal; };

  x->setZero(b.size());
  LinearIterate iterate;
  iterate.Resize(b.size());
  iterate.StartAtZero(b, precondition);
  return ConjugateGradients(multiply, precondition, is_enough, max_iterations, &iterate, x) && x->allFinite();
}

}  // namespace ch5
