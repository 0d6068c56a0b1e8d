#pragma once
/// Solvers for the reduced (camera) system  S Δx_p = b_s  of the fast room.

#include <memory>

#include "ch5_backend/solve/block_matrix.h"

namespace ch5 {

/// kAutomatic is dense for up to 300 numbers, and beyond where a sparse factorisation would take more than half of the
/// dense one's multiplications; otherwise it is sparse.
enum class ReducedSolverType { kAutomatic, kDenseCholesky, kSparseCholesky, kPcg };

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

/// The one that `type` names, for `size` unknowns; PCG to 1e-14.
std::unique_ptr<ReducedSolver> MakeReducedSolver(ReducedSolverType type, int size, int threads);

/// Dense Cholesky, n³/6 multiplications: best where nearly all poses share landmarks.
std::unique_ptr<ReducedSolver> MakeDenseCholesky();

/// Sparse Cholesky, see sparse_cholesky.h: best where a pose has few neighbours, as in a pose graph.
std::unique_ptr<ReducedSolver> MakeSparseCholesky(int threads);

/// Dense or sparse, by the rule of ReducedSolverType::kAutomatic.
std::unique_ptr<ReducedSolver> MakeCholesky(int threads);

/// Conjugate gradients, preconditioned by the inverses of S's diagonal blocks (Schur-Jacobi).
/// @param tolerance  stops at ‖r‖ ≤ tolerance·‖b‖, or after `max_iterations`
std::unique_ptr<ReducedSolver> MakeBlockPcg(int max_iterations, double tolerance);

}  // namespace ch5
