#pragma once
/// A start for poses in the plane, where angles add and even the rotations are linear but for whole turns:
///
///   1. turns     r_ij = wrap(θ_j − θ_i − θ_ij) at the chordal relaxation's angles (chordal.h), to which all edges have a part.
///                The paper's are a spanning tree's: errors along long branches add up to half a turn and more
///   2. angles    min Σ w (r_ij + φ_j − φ_i)²,   θ ← θ + φ,   w the angle's part of W
///   3. poses     min Σ rᵀWr over positions and small turns δθ at once, linear at these angles: there the measured p_ij
///                stands for R_iᵀ(p_j − p_i), which the positions do not give yet
///
/// Source: Carlone, Aragues, Castellanos, Bona, "A fast and accurate approximation for planar pose graph optimization",
/// IJRR 2014 (LAGO).

#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// Moves the poses from where the chordal relaxation has turned them.
/// @param edges    all EdgeSE2Between of the graph;  @param is_held  by the poses' ids
void PlaceInPlane(const std::vector<Edge*>& edges, const std::vector<bool>& is_held, Graph* graph, int threads);

}  // namespace ch5
