#pragma once
/// Solvers for the reduced (camera) system  S Δx_p = b_s  of the fast room.

#include <memory>

#include "ch5_backend/solve/block_matrix.h"

namespace ch5 {

enum class ReducedSolverType { kDenseCholesky, kPcg };

class ReducedSolver {
 public:
  virtual ~ReducedSolver() = default;
  /// A new pattern: memory may be taken here, and nowhere else.
  virtual void Prepare(const SymmetricBlockMatrix& S) = 0;
  /// @param scale  the damped diagonal of H_pp before the Schur complement: a pivot of n·ε times its entry is
  ///               rounding, and counts as zero
  /// @return false if S is not positive definite; `x` is then not to be used
  virtual bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& scale, VecX* x) = 0;
};

/// Dense Cholesky, n³/3: best up to a few hundred poses.
std::unique_ptr<ReducedSolver> MakeDenseCholesky();

/// Conjugate gradients, preconditioned by the inverses of S's diagonal blocks (Schur-Jacobi).
/// @param tolerance  stops at ‖r‖ ≤ tolerance·‖b‖, or after `max_iterations`
std::unique_ptr<ReducedSolver> MakeBlockPcg(int max_iterations, double tolerance);

}  // namespace ch5
