#pragma once
/// What the fast room does with each landmark and each pose; BlockSolver runs these passes over all of them.
///
/// A pass writes only what belongs to its chunk, its landmark or its column, in the order of the structure: any number of
/// threads gives the same bits. P and L are the poses' and landmarks' dimensions, or Eigen::Dynamic.

#include "ch5_backend/solve/normal_equations.h"
#include "ch5_backend/sparse/coupling_blocks.h"
#include "ch5_backend/sparse/linear_parts.h"
#include "ch5_backend/sparse/packed_edges.h"

namespace ch5 {

/// What the landmarks' edges add to the poses' rows: numbers laid out as those of H_pp and b_p.
struct PoseSums {
  AlignedVector H_pp, b;
};

/// The numbers behind BlockSolver; where what lies is said in block_structure.h.
struct BlockSystem {
  BlockStructure structure;
  InformationFactors factors;
  PackedEdges packed;          ///< the landmarks' edges, where they can be packed
  std::vector<PoseSums> sums;  ///< of each chunk of landmarks
  AlignedVector products;      ///< the normal equations of each edge between poses, negative
  SymmetricBlockMatrix H_pp, S;
  CouplingBlocks H_pm;
  std::vector<double> H_mm, H_mm_inverse;
  std::vector<double> H_mm_root;  ///< the lower triangles G⁻¹ of  H_ll⁻¹ = G⁻ᵀG⁻¹
  VecX b;                         ///< all rows
  VecX H_mm_inverse_b;            ///< the landmarks' rows
  VecX b_schur, scale;            ///< the poses' rows; scale is the damped diagonal of H_pp
  int pose_stride = 0;            ///< of the poses' parts of PoseSums::b
};

/// λ, and the entries of D.
struct DampingRule {
  double lambda;
  Damping damping;
};

/// The passes for one pair of dimensions and one kind of processor.
struct BlockPasses {
  bool fixed_size;  ///< made for these dimensions, and so for PackedEdges
  /// H_ll = Σ J̃_lᵀJ̃_l,  H_pl = Σ J̃_pᵀJ̃_l,  b_l = −Σ J̃_lᵀr̃  over the edges of each landmark of chunk c, which are
  /// linearised, and the chunk's parts of H_pp and b_p.
  void (*linearize_chunk)(BlockSystem*, int c);
  /// H_ij for all i ≥ j, and b_j: the chunks' sums, and the edges between poses.
  void (*sum_column)(BlockSystem*, int j);
  /// (H_ll + λD)⁻¹ and its product with b_l, for l in [begin, end). @return false if one is not positive definite
  bool (*invert_landmarks)(BlockSystem*, int begin, int end, const DampingRule&);
  /// Δx_l = H_ll⁻¹ (b_l − w),  w = Σ_p H_plᵀ Δx_p.  @return  Δx_lᵀ(b_l − w) − ½ Δx_lᵀH_llΔx_l, the landmark's part of
  /// the model's decrease
  double (*solve_landmark)(const BlockSystem&, int l, double* delta_x);
  /// (H v)_j += Σ_l H_jl v_l,  and (H v)_l = H_ll v_l + Σ_p H_plᵀ v_p.
  void (*multiply_pose)(const BlockSystem&, int j, const double* v, double* y);
  void (*multiply_landmark)(const BlockSystem&, int l, const double* v, double* y);
};

/// The passes made for these dimensions, H_pm's precision and this processor; any pair of sizes is served.
const BlockPasses& PassesFor(int pose_dim, int landmark_dim, bool single_precision);

}  // namespace ch5
