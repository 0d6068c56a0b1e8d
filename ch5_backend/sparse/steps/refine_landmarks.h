#pragma once
/// Each landmark by itself, while the poses stay: Gauss-Newton steps on the landmark's own edges,
///
///   (Σ ρ' J_lᵀWJ_l) δ = −Σ ρ' J_lᵀWr,   l ← l ⊞ δ,   kept where its cost falls.
///
/// The step Δx moves a landmark as if its residuals were linear, which those of an inverse depth or under a robust loss are
/// not; this makes good what it missed, at a fraction of its time.
/// Source: Jeong et al., "Pushing the Envelope of Modern Methods for Bundle Adjustment", PAMI 2012 (embedded point
/// iterations); Ceres calls them inner iterations.
///
/// A loss is concave in s = rᵀWr, so ρ(s') ≤ ρ(s) + ρ'(s)(s' − s): the cost falls by at least −½ Σ ρ'(s)(s' − s), which needs
/// no logarithm.

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/steps/weighted_edge_batch.h"

namespace ch5 {

/// Memory that is kept between calls.
struct LandmarkRefinement {
  struct Landmark {
    static constexpr int kMostRows = 3, kMostParameters = 4;
    double H[kMostRows * kMostRows], b[kMostRows];  ///< of its edges at its present place; of H the lower half
    double change;                                  ///< of its cost by the last step, at most
    double decrease;                                ///< of its cost by all steps, at least
    double before[kMostParameters];                 ///< its parameters before the last step
    bool is_done;                                   ///< it stays where it is
  };
  Array<Landmark> landmarks;
  Array<double> squares, slopes;  ///< s and ρ'(s) of each edge at the landmark's present place
  Array<double> decreases;        ///< of each chunk
};

/// Moves the landmarks, by at most so many steps each. The batches are active, their poses loaded.
/// @return by how much the cost fell, at least
double RefineLandmarks(const Structure& structure, const LandmarkEdgeBatches& batches, int steps, ThreadPool* pool,
                       LandmarkRefinement* refinement);

}  // namespace ch5
