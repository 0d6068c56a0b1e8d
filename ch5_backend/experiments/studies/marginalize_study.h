#pragma once
/// Stage 2 as pictures: the slides' chain of three scalars, and what marginalizing fills in on a real scene.

#include <filesystem>
#include <functional>

namespace ch5 {

/// Writes marginalize_chain.csv (before, moved, after), marginalize_scene.csv and marginalize_fill.csv: a scene of
/// 5 frames × 12 points loses its landmarks, then frame 0; or frame 0 at once, which couples every landmark.
/// @param progress  called with the fraction done;  @throws WriteError
void RunMarginalizeStudy(const std::filesystem::path& csv, const std::function<void(double)>& progress);

}  // namespace ch5
