#pragma once
/// Stage 3, the prior-weight experiment: what does a prior of weight w on the first frames do to convergence, and
/// what to the answer?
///
/// Three variants (see PriorVariants): the course's own setting, which is degenerate; a meaningful one; and the
/// minimal gauge, whose seven constraints hold seven free directions and nothing else.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/evaluate/reconstruction.h"

namespace ch5 {

struct PriorVariant {
  std::string name;
  MonoBaOptions scene;
  Gauge gauge;
  double pixel_information;  ///< W = pixel_information·I₂
  Damping damping;
};

/// One solve at one weight.
struct PriorRun {
  Summary summary;
  double milliseconds = 0.0;       ///< processor time of the solve, which waits for no other program
  double reprojection_cost = 0.0;  ///< ½ Σ rᵀWr of the observations at the end …
  double prior_cost = 0.0;         ///< … and of the priors
  double drift_position = 0.0;     ///< of frame 0 from its prior [m]
  double drift_rotation = 0.0;     ///< [rad]
  Rmse rmse;                       ///< after alignment by a similarity
};

/// "course": poses start at the truth, W = I, identity damping, 6 + 6 constraints.
/// "perturbed": poses start 10 cm and 2° (one σ, each axis) beside it, W = 1/σ², diagonal damping, 6 + 6 constraints.
/// "minimal": likewise with 6 + 1 constraints, pose 0 and the length of the baseline.
std::vector<PriorVariant> PriorVariants();

/// 0, then 1 and 3 times each power of ten from 1e-3, up to 1e10.
std::vector<double> PriorWeights();

/// Tight relative rules, so that what is left of a difference is not where the iteration happened to stop. Weights so
/// small that the prior's cost drowns in the rounding of the observations' (below 0.1 with W = 1/σ²) still end by luck
/// or at max_iterations: their counts differ between machines.
SolveOptions TightOptions();
/// The usual rules (cost to 1e-6 of itself), with iterations enough.
SolveOptions UsualOptions();

PriorRun RunPrior(const PriorVariant& variant, const MonoBaScene& scene, double weight, const SolveOptions& options);

/// Writes
///   prior_sweep.csv, prior_trace.csv  one scene under tight rules, as a student sees it;
///   prior_trials.csv   means over many scenes under the usual rules: one scene's whole numbers are an anecdote;
///   prior_damping.csv  the course's variant with either damping: λ₀ = τ max diag(H) grows with the weight.
/// @param progress  called with the fraction done
/// @throws WriteError
void RunPriorStudy(const std::filesystem::path& csv, const std::function<void(double)>& progress);

}  // namespace ch5
