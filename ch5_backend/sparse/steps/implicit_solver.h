#pragma once
/// Solvers for the reduced system  S Δx_p = b_S  that never form S: they only multiply by it (implicit_schur.h).
///
/// For many poses, whose S is large though each sees little of the scene. Both methods stop where the accuracy asked is
/// reached, so a loose one, as Levenberg-Marquardt far from the optimum deserves, costs few products.

#include <memory>

#include "ch5_backend/sparse/steps/implicit_schur.h"

namespace ch5 {

class ImplicitSolver {
 public:
  virtual ~ImplicitSolver() = default;
  /// A new structure: memory may be taken here, and nowhere else. `structure` and `pool` must outlive the other calls.
  virtual void Prepare(const Structure& structure, ThreadPool* pool) = 0;
  /// Solves with the landmarks' inverses, which must be damped by `rule`; leaves b_S and B's diagonal in `eliminated`.
  /// @return false if S is seen not to be positive definite; otherwise the iterate, as accurate as was asked or after
  ///         the maximum of iterations
  virtual bool Solve(const Linearized& system, const DampingRule& rule, Eliminated* eliminated, VecX* x) = 0;
  /// Products with S in the last Solve.
  virtual int Products() const = 0;
};

/// @param type  kImplicitPcg or kPowerSeries
///
/// Conjugate gradients, preconditioned by the inverses of the diagonal blocks of S or of B.
///
/// Power series (Weber et al., "Power bundle adjustment for large-scale 3D reconstruction", CVPR 2023):
///   S⁻¹ = Σ_i (B⁻¹C)^i B⁻¹,   for S and B positive definite the eigenvalues of B⁻¹C lie in [0, 1)
/// whose terms are t_0 = B⁻¹b, t_{i+1} = B⁻¹(b − S Σ_{k≤i} t_k): the residual comes for free, and tells when enough
/// terms are summed. B⁻¹ is that of the diagonal blocks. Should poses be tied by edges so that the series diverges, or
/// should it need more terms than the maximum, conjugate gradients go on from its sum.
std::unique_ptr<ImplicitSolver> MakeImplicitSolver(ReducedSolverType type, const IterativeOptions& options);

}  // namespace ch5
