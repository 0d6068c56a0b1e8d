#pragma once
/// Dense linear solvers for symmetric systems  A x = b.

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// A x = b by LDLᵀ.
/// @param A  n×n symmetric, full storage;  @param b  n×1
/// @return false if A is not positive definite by the measure of pivot_rule.h, or if x is not finite
bool SolveLdlt(const MatXX& A, const VecX& b, VecX* x);

/// Conjugate gradients (conjugate_gradients.h) with Jacobi preconditioning, M = diag A.
/// @param tolerance  stops at ‖b − A x‖ ≤ tolerance·‖b‖, or after `max_iterations`
/// @return false if A is seen not to be positive definite; otherwise the iterate, converged or not
bool SolvePcg(const MatXX& A, const VecX& b, int max_iterations, double tolerance, VecX* x);

}  // namespace ch5
