#pragma once
/// Back to the landmarks, once the poses' step is known:
///
///   Δx_l = (H_ll + λD)⁻¹ (b_l − Σ_p H_plᵀ Δx_p)                                      Triggs (2000), §6.1
///
/// and what the quadratic model predicts for the whole step,  bᵀΔx − ½ ΔxᵀHΔx,  which comes along: a landmark's part is
/// Δx_lᵀ(b_l − w) − ½ Δx_lᵀH_llΔx_l  with w = Σ_p H_plᵀ Δx_p,  the poses' part Δx_pᵀ(b_p − ½ H_pp Δx_p).

#include "ch5_backend/sparse/steps/eliminate.h"

namespace ch5 {

/// A step, and the decrease of ½ Σ ρ that the model predicts for it.
struct Step {
  VecX delta_x;  ///< all rows, poses first
  double model_cost_change = 0.0;

  /// Memory that BackSubstitute works in: H_pp Δx_p, and the sums of its tasks.
  VecX H_pp_delta;
  Array<double> partial_sums;
};

/// Completes a step whose poses' rows are given.
/// @param step  delta_x and H_pp_delta have all their rows; the poses' rows of delta_x solve S Δx_p = b_S
void BackSubstitute(const Structure& structure, const Linearized& system, const Eliminated& eliminated,
                    ThreadPool* pool, Step* step);

}  // namespace ch5
