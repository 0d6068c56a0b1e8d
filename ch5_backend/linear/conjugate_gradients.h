#pragma once
/// Preconditioned conjugate gradients for A x = b, with A and the preconditioner M symmetric and positive definite.
///
///   p = z at first, then until x is good enough
///   α = rᵀz / pᵀAp,   x += α p,   r −= α A p,   z = M⁻¹ r,   β = rᵀz / (rᵀz before),   p = z + β p
///
/// A and M⁻¹ are functions, so neither needs to exist as a matrix. Every step decreases the model ½ xᵀAx − bᵀx by
/// ½ α rᵀz, so its decrease Q = bᵀx − ½ xᵀAx is known without another product.
///
/// Source: Golub & Van Loan, "Matrix Computations", 4th ed., alg. 11.5.1.

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// What an iterative solver knows of its iterate x, and the memory that it works in.
struct LinearIterate {
  VecX r;                        ///< n×1, the residual b − A x
  VecX z;                        ///< n×1, M⁻¹ r
  double rMr = 0.0;              ///< rᵀ M⁻¹ r
  double decrease = 0.0;         ///< Q = bᵀx − ½ xᵀAx
  double decrease_before = 0.0;  ///< Q of the iterate before this one
  int count = 0;                 ///< iterations so far, one product with A each
  VecX p, Ap;                    ///< n×1, the search direction and A times it

  /// Takes the memory for n unknowns: the iterations themselves take none.
  void Resize(Eigen::Index n) {
    for (VecX* v : {&r, &z, &p, &Ap}) v->setZero(n);
  }

  /// The iterate x = 0 of A x = b.
  template <typename Precondition>
  void StartAtZero(const VecX& b, const Precondition& precondition) {
    r = b;
    precondition(r, &z);
    rMr = r.dot(z);
    decrease = decrease_before = 0.0;
    count = 0;
  }
};

/// Improves `x`, which may come from another solver, until is_enough(state), until the residual is zero, or until
/// state->count reaches `max_count`.
/// @param multiply  multiply(v, &Av) computes A v;  @param precondition  precondition(r, &z) computes z = M⁻¹ r
/// @param is_enough  the stop rule, bool(const LinearIterate&), asked after every iteration
/// @param state  in: r, z, rMr, decrease and count of `x`, as of StartAtZero; out: those of the final `x`
/// @return false if A or M is seen not to be positive definite; otherwise x is the last iterate, good enough or not
template <typename Multiply, typename Precondition, typename StopRule>
bool ConjugateGradients(const Multiply& multiply, const Precondition& precondition, const StopRule& is_enough,
                        int max_count, LinearIterate* state, VecX* x) {
  LinearIterate& s = *state;
  s.p = s.z;
  while (s.rMr != 0.0 && s.count < max_count) {
    multiply(s.p, &s.Ap);
    const double curvature = s.p.dot(s.Ap);
    if (!(s.rMr > 0.0 && curvature > 0.0)) return false;  // of a NaN, too
    const double alpha = s.rMr / curvature;
    *x += alpha * s.p;
    s.r -= alpha * s.Ap;
    precondition(s.r, &s.z);
    const double rMr_before = s.rMr;
    s.rMr = s.r.dot(s.z);
    s.decrease_before = s.decrease;
    s.decrease += 0.5 * alpha * rMr_before;
    ++s.count;
    if (is_enough(s)) return true;
    s.p = s.z + (s.rMr / rMr_before) * s.p;
  }
  return true;
}

}  // namespace ch5
