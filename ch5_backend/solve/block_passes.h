#pragma once
/// What the fast room does with each landmark and each pose; BlockSolver runs these passes over all of them.
///
/// A pass writes only what belongs to its landmark or its column, in the order of the graph: any number of threads
/// gives the same bits. P and L are the poses' and landmarks' dimensions, or Eigen::Dynamic.

#include "ch5_backend/solve/block_structure.h"
#include "ch5_backend/solve/normal_equations.h"

namespace ch5 {

/// The numbers behind BlockSolver; where what lies is said in block_structure.h.
struct BlockSystem {
  BlockStructure structure;
  AlignedVector linear;  ///< the edges' whitened residuals and Jacobians
  SymmetricBlockMatrix H_pp, S;
  AlignedVector H_pm;
  std::vector<double> H_mm, H_mm_inverse;
  VecX b;               ///< all rows
  VecX H_mm_inverse_b;  ///< the landmarks' rows
  VecX b_schur, scale;  ///< the poses' rows; scale is the damped diagonal of H_pp
};

/// λ, and the entries of D.
struct DampingRule {
  double lambda;
  Damping damping;
};

/// The passes for one pair of dimensions and one kind of processor.
struct BlockPasses {
  /// H_ll = Σ J̃_lᵀJ̃_l,  H_pl = Σ J̃_pᵀJ̃_l,  b_l = −Σ J̃_lᵀr̃  over the edges of landmark l, which are linearised.
  void (*linearize_landmark)(BlockSystem*, int l);
  /// H_ij = Σ J̃_iᵀJ̃_j for all i ≥ j,  b_j = −Σ J̃_jᵀr̃.
  void (*sum_column)(BlockSystem*, int j);
  /// (H_ll + λD)⁻¹ and its product with b_l. @return false if it is not positive definite
  bool (*invert_landmark)(BlockSystem*, int l, const DampingRule&);
  /// Column j of  S = H_pp + λD − Σ_l H_pl H_ll⁻¹ H_plᵀ  and rows j of  b_p − Σ_l H_pl H_ll⁻¹ b_l.
  void (*schur_column)(BlockSystem*, int j, const DampingRule&);
  /// Δx_l = H_ll⁻¹ (b_l − w),  w = Σ_p H_plᵀ Δx_p.  @return  Δx_lᵀ(b_l − w) − ½ Δx_lᵀH_llΔx_l, the landmark's part of
  /// the model's decrease
  double (*solve_landmark)(const BlockSystem&, int l, double* delta_x);
  /// (H v)_j += Σ_l H_jl v_l,  and (H v)_l = H_ll v_l + Σ_p H_plᵀ v_p.
  void (*multiply_pose)(const BlockSystem&, int j, const double* v, double* y);
  void (*multiply_landmark)(const BlockSystem&, int l, const double* v, double* y);
};

/// The passes made for these dimensions and this processor; any pair of sizes is served.
const BlockPasses& PassesFor(int pose_dim, int landmark_dim);

}  // namespace ch5
