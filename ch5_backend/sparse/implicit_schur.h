#pragma once
/// The reduced system  S Δx_p = b_s  without S: a product with it, its right-hand side, and a block preconditioner.
///
///   S = B − W,   B = H_pp + λD,   W = E C⁻¹ Eᵀ (see schur_coupling.h),   b_s = b_p − E C⁻¹ b_m

#include "ch5_backend/linear/reduced_solver.h"
#include "ch5_backend/sparse/schur_coupling.h"

namespace ch5 {

class ImplicitSchur {
 public:
  /// The dimensions are BlockSolver's.
  ImplicitSchur(int pose_dim, int landmark_dim);

  /// Takes the memory for a new structure. `system` and `pool` must outlive all other calls.
  void Prepare(BlockSystem* system, ThreadPool* pool);
  /// Damps B, whose diagonal goes to the system's `scale`; makes b_s, in the system's `b_schur`, and M⁻¹.
  /// H_mm_inverse and H_mm_inverse_b must be damped by the same rule already.
  /// @return false if a block of M is not positive definite: S is not then
  bool Damp(const DampingRule& rule, Preconditioner preconditioner);

  /// y = S x and z = M⁻¹ r.
  void Multiply(const VecX& x, VecX* y);
  void Precondition(const VecX& r, VecX* z) const;

 private:
  struct PoseTask;  // what one pose contributes to Damp
  using ReducePose = void (*)(const PoseTask&, double* block);
  template <int P, int L>
  struct Reduce;
  static ReducePose ReduceFor(int pose_dim, int landmark_dim);

  SchurCoupling coupling_;
  ReducePose reduce_;
  BlockSystem* system_ = nullptr;
  ThreadPool* pool_ = nullptr;
  int max_landmark_dim_ = 0;
  std::vector<int> block_begin_;       // of each pose's block of M⁻¹
  std::vector<double> inverses_, Wx_;  // without padding
  VecX damping_;                       // λD
};

}  // namespace ch5
