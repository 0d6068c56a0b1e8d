#pragma once
/// The reduced system  S Δx_p = b_S  solved without S, for many poses, each of which sees little of the scene:
///
///   S = B − C,   B = H_pp + λD,   C = Σ_l H_pl (H_ll + λD)⁻¹ H_plᵀ,   b_S = b_p − Σ_l H_pl (H_ll + λD)⁻¹ b_l
///
/// C x, landmark by landmark:   v = (H_ll + λD)⁻¹ Σ_p H_plᵀ x_p,   (C x)_p += H_pl v  while its blocks are still cached.
/// That is two small products a slot, where S would have a block for each pair of poses of each landmark. It is bound by
/// the memory that H_pl fills: an inexact solver has it by its factors (kernels/slot_factors.h). Each chunk of landmarks
/// has sums of its own, added in order; chunks are cut by the structure alone, so the result is the same to the bit for
/// any number of threads.
///
/// Two methods need no more than such products (Agarwal et al., "Bundle adjustment in the large", ECCV 2010). Both stop where
/// the accuracy asked is reached, so a loose one, as Levenberg-Marquardt far from the optimum deserves, costs few of them.
///   conjugate gradients   preconditioned by the inverses of the diagonal blocks of S or of B
///   power series          S⁻¹ = Σ_i (B⁻¹C)^i B⁻¹,  B⁻¹ that of the diagonal blocks: for S and B positive definite the
///                         eigenvalues of B⁻¹C lie in [0, 1). The terms are t_0 = B⁻¹b, t_{i+1} = B⁻¹(b − S Σ_{k≤i} t_k):
///                         the residual comes for free, and shows when enough are summed. Should poses be tied by edges so
///                         that the series diverges, or should it need more terms than the maximum, conjugate gradients go
///                         on from its sum. Weber et al., "Power bundle adjustment for large-scale 3D reconstruction",
///                         CVPR 2023

#include "ch5_backend/linear/conjugate_gradients.h"
#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/sparse/steps/eliminate.h"

namespace ch5 {

/// Products with S, its right-hand side, and a block preconditioner (implicit_schur.cc).
class ImplicitSchur {
 public:
  /// Takes the memory for a new structure. `structure` and `pool` must outlive all other calls.
  void Prepare(const Structure& structure, ThreadPool* pool);
  /// Damps B, whose diagonal goes to `damped_diagonal`; makes b_S, and M⁻¹. The landmarks must have been inverted with the
  /// same rule. `system` and `eliminated` must stay as they are until the last product.
  /// @return false if a block of M is not positive definite: S is not then
  bool Damp(const Linearized& system, const DampingRule& rule, Preconditioner preconditioner, Eliminated* eliminated);

  /// y = S x and z = M⁻¹ r.
  void Multiply(const VecX& x, VecX* y);
  void Precondition(const VecX& r, VecX* z) const;

 private:
  void CutChunks();
  void MultiplyCoupling(const double* x, double* y);
  bool InvertDiagonalBlock(int j, const DampingRule& rule, Preconditioner preconditioner, Eliminated* eliminated);

  const Structure* structure_ = nullptr;
  const Linearized* system_ = nullptr;
  const Eliminated* eliminated_ = nullptr;
  ThreadPool* pool_ = nullptr;
  BlockSizes sizes_;  // of all poses and landmarks
  int max_landmark_dim_ = 0;
  // A chunk of landmarks, and y of the poses that see them: each begins at padded_offset, or has −1.
  struct Chunk {
    int begin, end;
    Array<int> padded_offset;
    AlignedVector sums;
  };
  Array<Chunk> chunks_;
  Array<int> block_begin_;       // of each pose's block of M⁻¹
  Array<double> inverses_, Cx_;  // without padding
  VecX damping_;                 // λD
};

class ImplicitSolver {
 public:
  /// @param type  kImplicitPcg or kPowerSeries
  ImplicitSolver(ReducedSolverType type, const IterativeOptions& options)
      : is_series_(type == ReducedSolverType::kPowerSeries), options_(options) {}

  /// A new structure: memory is taken here, and nowhere else. `structure` and `pool` must outlive the other calls.
  void Prepare(const Structure& structure, ThreadPool* pool);
  /// Solves with the landmarks' inverses, which must be damped by `rule`; leaves b_S and B's diagonal in `eliminated`.
  /// @return false if S is seen not to be positive definite; otherwise the iterate, as accurate as was asked or after
  ///         the maximum of iterations
  bool Solve(const Linearized& system, const DampingRule& rule, Eliminated* eliminated, VecX* x);
  /// Products with S in the last Solve.
  int Products() const { return state_.count; }

 private:
  bool IsEnough(double error, const LinearIterate& x) const;
  bool SumSeries(const VecX& b, VecX* x);

  bool is_series_;
  IterativeOptions options_;
  double goal_ = 0.0;  // for rᵀM⁻¹r
  ImplicitSchur S_;
  LinearIterate state_;  // of the last Solve; count is its products
};

}  // namespace ch5
