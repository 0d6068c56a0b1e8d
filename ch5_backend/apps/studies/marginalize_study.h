#pragma once
/// Stage 2 as pictures: the slides' chain of three scalars, and what marginalising fills in on a real scene.

#include <filesystem>
#include <functional>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// H of the slides' chain of three scalars: x₁ is measured, and its distances to x₀ and x₂.
///
///   H = [  w₁      −w₁       0  ]     w_i = 1/σ_i²,  σ = 0.1, 0.2, 0.3:
///       [ −w₁  w₁+w₂+w₃    −w₃  ]     σ₁ and σ₃ of the distances, σ₂ of x₁ itself
///       [   0      −w₃      w₃  ]
MatXX SlidesChain();

/// Writes marginalize_chain.csv (before, moved, after), marginalize_scene.csv and marginalize_fill.csv: a scene of
/// 5 frames × 12 points loses its landmarks, then frame 0; or frame 0 at once, which couples every landmark.
/// @param progress  called with the fraction done;  @throws WriteError
void RunMarginalizeStudy(const std::filesystem::path& csv, const std::function<void(double)>& progress);

}  // namespace ch5
