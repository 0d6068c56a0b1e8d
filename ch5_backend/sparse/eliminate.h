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
///             one of the fixed sizes (math/dispatch.h): kernels/schur_group.h
///   general   the same for any sizes, also mixed: all A_i below each other, then C = A Aᵀ by a dense kernel, whose blocks
///             are taken from S. In eliminate.cc
///   implicit  S is never formed, only multiplied by a vector: for many poses, implicit_schur.h
/// Each thread has a range of S's columns and walks all groups, so every block is summed in the same order for any number
/// of threads, in one copy of S.

#include "ch5_backend/solve/normal_equations.h"
#include "ch5_backend/sparse/linearize.h"
#include "ch5_backend/sparse/schur_groups.h"

namespace ch5 {

/// λ, and the entries of D.
struct DampingRule {
  double lambda;
  Damping damping;
};

struct Eliminated {
  std::vector<double> H_ll_inverse;  ///< (H_ll + λD)⁻¹, see Structure::landmark_block
  std::vector<double> G_inverse;     ///< its lower triangles G⁻¹
  VecX H_ll_inverse_b;               ///< (H_ll + λD)⁻¹ b_l, the landmarks' rows
  SymmetricBlockMatrix S;            ///< empty if S is implicit
  VecX b_S;
  VecX damped_diagonal;  ///< of H_pp + λD: what a pivot of S is compared with, linear/pivot_rule.h

  /// Takes all memory for this structure, S's aside.
  void Resize(const Structure& structure);
};

/// (H_ll + λD)⁻¹ and its product with b_l, for every landmark.
/// @return false if one of the damped blocks is not positive definite
bool InvertLandmarks(const Structure& structure, const Linearized& system, const DampingRule& rule, ThreadPool* pool,
                     Eliminated* eliminated);

/// Finds the groups for FormSchurComplement, with the memory that its variant for these sizes needs.
/// @param S  has its pattern (SchurPattern)
SchurGroups PrepareSchurGroups(const Structure& structure, const SymmetricBlockMatrix& S, int threads);

/// S and b_S from the inverted landmarks; S has its pattern.
void FormSchurComplement(const Structure& structure, const Linearized& system, const DampingRule& rule,
                         SchurGroups* groups, ThreadPool* pool, Eliminated* eliminated);

}  // namespace ch5
