#pragma once
/// Solvers for the reduced (camera) system  S Δx_p = b_S  of the sparse solver.

#include <memory>
#include <utility>

#include "ch5_backend/linear/block_matrix.h"
#include "ch5_backend/math/parallel.h"

namespace ch5 {

/// kAutomatic, in three steps: a power series for more than 400 poses that only landmarks connect, which near the minimum
/// is replaced by the next solver unless that is too slow (NormalEquations::SolveExactly); otherwise dense for up to 100
/// unknowns, or where S has more than 70 % of its blocks; otherwise sparse, unless that takes more than half of the dense
/// one's multiplications. (A window's speeds and biases are a chain: with them half of S is empty.)
/// The last two types never form S, see sparse/steps/implicit_solver.h.
enum class ReducedSolverType { kAutomatic, kDenseCholesky, kSparseCholesky, kPcg, kImplicitPcg, kPowerSeries };

/// The types by name, in the order above.
inline constexpr std::pair<const char*, ReducedSolverType> kReducedSolverNames[] = {
    {"automatic", ReducedSolverType::kAutomatic},      {"dense", ReducedSolverType::kDenseCholesky},
    {"sparse", ReducedSolverType::kSparseCholesky},    {"pcg", ReducedSolverType::kPcg},
    {"implicit-pcg", ReducedSolverType::kImplicitPcg}, {"power-series", ReducedSolverType::kPowerSeries},
};

/// M, block diagonal, so that M⁻¹S is nearer to the identity: the diagonal blocks of H_pp + λD (block-Jacobi) cost
/// nothing; those of S (Schur-Jacobi) cost a small product per slot. They save up to two fifths of the iterations on BAL's two
/// problems of tests/bench, and cost up to a third more on its 969 cameras.
enum class Preconditioner { kBlockJacobi, kSchurJacobi };

/// How accurately kImplicitPcg and kPowerSeries solve. The defaults are those of an inexact Newton method, loose on
/// purpose: the rest of the model's decrease lies in directions that the scene hardly determines, where the model is
/// not valid far. (The 969 cameras of tests/bench: 20 iterations at 0.7 end within 1 % of those at 0.1, in about their
/// time, and with Huber's loss in a tenth of it.) Near the minimum, steps so loose creep along chains of poses.
/// IterativeOptions::Exact() is for callers that need S⁻¹ itself.
struct IterativeOptions {
  double tolerance = 0.0;  ///< stops if √(rᵀM⁻¹r) ≤ tolerance·√(bᵀM⁻¹b)
  double model_tolerance = 0.7;  ///< or if i (Q_i − Q_{i−1}) < model_tolerance·Q_i, Q = bᵀx − ½xᵀSx (Nash & Sofer 1990)
  int max_iterations = 500;
  int max_terms = 100;  ///< of the power series; if they do not suffice, conjugate gradients continue from their sum
  Preconditioner preconditioner = Preconditioner::kSchurJacobi;  ///< of PCG; the power series has B's blocks

  /// @throws OptionError
  void Validate() const;

  static IterativeOptions Exact() { return {1e-15, 0.0, 10000, 100, Preconditioner::kSchurJacobi}; }
};

class ReducedSolver {
 public:
  virtual ~ReducedSolver() = default;
  /// A new pattern. Memory is allocated here and nowhere else.
  /// @param pool  what Solve may share its work with, as long as it is called; null: the calling thread alone
  virtual void Prepare(const SymmetricBlockMatrix& S, ThreadPool* pool) = 0;
  /// @param scale  the damped diagonal of H_pp before the Schur complement: a pivot of n·ε times its entry is
  ///               rounding and counts as zero, see pivot_rule.h
  /// @return false if S is not positive definite; `x` is then not to be used
  virtual bool Solve(const SymmetricBlockMatrix& S, const VecX& b, const VecX& scale, VecX* x) = 0;
};

/// The first step of kAutomatic: an implicit type, or kAutomatic where S is to be formed. Others are returned as is.
/// @param tied_by_landmarks_alone  no edge has two free poses
ReducedSolverType ChooseReducedSolver(ReducedSolverType type, int num_poses, bool tied_by_landmarks_alone);

/// The one that `type` names: dense Cholesky, n³/6 multiplications, best where nearly all poses share landmarks; sparse
/// Cholesky (sparse_cholesky.h), best where a pose has few neighbors, as in a pose graph; PCG to 1e-14. Of kAutomatic and of
/// the implicit types, dense or sparse by the rule above.
std::unique_ptr<ReducedSolver> MakeReducedSolver(ReducedSolverType type);

/// Conjugate gradients, preconditioned by the inverses of S's diagonal blocks (Schur-Jacobi).
/// @param tolerance  stops at ‖r‖ ≤ tolerance·‖b‖, or after 10 n + 100 iterations
std::unique_ptr<ReducedSolver> MakeBlockPcg(double tolerance);

/// x = S⁺b by the eigenvectors of S: a free gauge solved without damping, for up to a few hundred unknowns. The step has
/// the smallest norm of all that solve the system, counting the poses; the landmarks follow.
/// @param nullity  how many of S's smallest eigenvalues are those of the gauge, 4 or 7; they count as zero
std::unique_ptr<ReducedSolver> MakePseudoInverse(int nullity);

}  // namespace ch5
