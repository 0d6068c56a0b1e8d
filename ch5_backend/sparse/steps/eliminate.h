#pragma once
/// The landmarks are eliminated; a system of the poses alone remains:  S Δx_p = b_S  with
///
///   S = H_pp + λD − Σ_l H_pl (H_ll + λD)⁻¹ H_plᵀ,    b_S = b_p − Σ_l H_pl (H_ll + λD)⁻¹ b_l       Triggs (2000), §6.1
///
/// H_ll is damped before it is inverted:  H_ll + λD = G Gᵀ  by Cholesky,  (H_ll + λD)⁻¹ = G⁻ᵀ G⁻¹.
///
/// S is decreased in three ways, which give the same sums:
///   grouped   landmarks that the same poses see change the same blocks of S; with A_i = [H_il G_l⁻ᵀ  H_im G_m⁻ᵀ …] for
///             the landmarks l, m, … of the group, S_ij −= A_i A_jᵀ, block by block in registers. Where all blocks have
///             one size, of those that fit registers (math/dispatch.h)
///   general   the same for any sizes, also mixed: all A_i below each other, then C = A Aᵀ by a dense kernel, whose blocks
///             are taken from S. Both in kernels/schur_group.h
///   implicit  S is never formed, only multiplied by a vector: for many poses, implicit_solver.h
/// Each thread has a range of S's columns and walks all groups, so every block is summed in the same order for any number
/// of threads, in one copy of S.

#include "ch5_backend/solve/normal_equations.h"
#include "ch5_backend/sparse/kernels/schur_group.h"
#include "ch5_backend/sparse/steps/linearize.h"

namespace ch5 {

/// λ, and the entries of D.
struct DampingRule {
  double lambda;
  Damping damping;
};

struct Eliminated {
  AlignedVector H_ll_inverse;  ///< (H_ll + λD)⁻¹, see Numbering::landmark_block
  AlignedVector G_inverse;     ///< its lower triangles G⁻¹, which only forming S wants; or empty
  VecX H_ll_inverse_b;         ///< (H_ll + λD)⁻¹ b_l, the landmarks' rows
  SymmetricBlockMatrix S;      ///< empty if S is implicit
  VecX b_S;
  VecX damped_diagonal;  ///< of H_pp + λD: what a pivot of S is compared with, linear/pivot_rule.h

  /// Takes all memory for this structure, S's aside.
  void Resize(const Structure& structure, bool is_implicit = false);
};

/// Used as G⁻¹ where A = H_ll + λD is not positive definite: K, lower triangular, of which KᵀK counts as A⁻¹.
using SingularRoot = MatXX (*)(const MatXX& A);

/// (H_ll + λD)⁻¹ and its product with b_l, for every landmark.
/// @param singular_root  for blocks that are not positive definite, where S is formed; or null
/// @return false if one of the damped blocks is not positive definite, and it has no substitute for its inverse
bool InvertLandmarks(const Structure& structure, const Linearized& system, const DampingRule& rule, ThreadPool* pool,
                     Eliminated* eliminated, SingularRoot singular_root = nullptr);

/// Rows i ≥ j of each column of S, which ties all poses that see one landmark.
Lists SchurPattern(const Structure& structure);

/// Consecutive landmarks that the same poses see: they change the same blocks of S.
struct SchurGroup {
  int first, last;             ///< landmarks
  int poses_begin, poses_end;  ///< in SchurGroups::poses, by ascending number
  int rows;                    ///< of all poses together
  int blocks_begin;  ///< its blocks of S in SchurGroups::blocks: column by column, each from the diagonal down
};

/// All groups of a structure, and the work of each thread on them.
struct SchurGroups {
  Array<SchurGroup> groups;
  Array<kernels::GroupPose> poses;
  Array<int> blocks;

  /// The columns of S that are one thread's work, poses [begin, end), and the memory that it works in.
  struct ColumnRange {
    int begin, end;
    AlignedVector memory;
  };
  Array<ColumnRange> ranges;  ///< of about equal work

  /// The poses of a group whose columns are in a range.
  kernels::PoseRange PosesIn(const SchurGroup& group, const ColumnRange& range) const;
};

/// Finds the groups for FormSchurComplement, once for a structure, and allocates what they need.
/// @param S        has its pattern (SchurPattern)
/// @param threads  for which the columns are cut into ranges
SchurGroups PrepareSchurGroups(const Structure& structure, const SymmetricBlockMatrix& S, int threads);

/// S and b_S from the inverted landmarks; S has its pattern.
void FormSchurComplement(const Structure& structure, const Linearized& system, const DampingRule& rule,
                         SchurGroups* groups, ThreadPool* pool, Eliminated* eliminated);

}  // namespace ch5
