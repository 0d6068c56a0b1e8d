#pragma once
/// Solvers for the reduced system  S Δx_p = b_s  that never form S: they only multiply by it (see schur_coupling.h).
///
///   S = B − W,   B = H_pp + λD,   W = H_pm (H_mm + λD)⁻¹ H_pmᵀ,   b_s = b_p − H_pm (H_mm + λD)⁻¹ b_m
///
/// For many cameras, whose S is large though each sees little of the scene. Both methods stop where the accuracy asked
/// is reached, so a loose one, as Levenberg-Marquardt far from the optimum deserves, costs few products.

#include <memory>

#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/schur_coupling.h"

namespace ch5 {

class ImplicitSolver {
 public:
  virtual ~ImplicitSolver() = default;
  /// A new structure: memory may be taken here, and nowhere else. `system` and `pool` must outlive the other calls.
  virtual void Prepare(BlockSystem* system, ThreadPool* pool) = 0;
  /// Solves with the system's present H_mm_inverse and H_mm_inverse_b, which must be damped by `rule`; leaves b_s and
  /// B's diagonal in the system.
  /// @return false if S is seen not to be positive definite; otherwise the iterate, as accurate as was asked or after
  ///         the maximum of iterations
  virtual bool Solve(BlockSystem* system, const DampingRule& rule, VecX* x) = 0;
  /// Products with S in the last Solve.
  virtual int Products() const = 0;
};

/// @param type  kImplicitPcg or kPowerSeries
///
/// Conjugate gradients, preconditioned by the inverses of the diagonal blocks of S or of B.
///
/// Power series (Weber et al., "Power bundle adjustment for large-scale 3D reconstruction", CVPR 2023):
///   S⁻¹ = Σ_i (B⁻¹W)^i B⁻¹,   for S and B positive definite the eigenvalues of B⁻¹W lie in [0, 1)
/// whose terms are t_0 = B⁻¹b, t_{i+1} = B⁻¹(b − S Σ_{k≤i} t_k): the residual comes for free, and tells when enough
/// terms are summed. B⁻¹ is that of the diagonal blocks. Should poses be tied by edges so that the series diverges, or
/// should it need more terms than the maximum, conjugate gradients go on from its sum.
std::unique_ptr<ImplicitSolver> MakeImplicitSolver(ReducedSolverType type, const IterativeOptions& options,
                                                   int pose_dim, int landmark_dim);

}  // namespace ch5
