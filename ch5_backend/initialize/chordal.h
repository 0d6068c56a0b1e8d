#pragma once
/// A start for a pose graph that no bad path spoils: chordal relaxation, two linear problems in place of one that is not.
///
///   1. rotations   min Σ κ ‖R_j − R_i R_ij‖²_F   over unconstrained matrices R_i, hence linear:
///                  one linear problem with three right-hand sides, the columns of R_iᵀ
///   2. projection  R_i = U diag(1, 1, det UVᵀ) Vᵀ of the singular values R_i = U S Vᵀ: the nearest rotation
///   3. positions   min Σ rᵀWr   for these rotations: the graph's own cost, in which positions are linear
///
/// κ is the mean of the rotation's part of W's diagonal. In the plane the rotations are only the beginning: planar.h.
/// Source: Carlone, Tron, Daniilidis, Dellaert, "Initialization techniques for 3D SLAM", ICRA 2015; Martinec & Pajdla,
/// "Robust rotation and translation estimation in multiview reconstruction", CVPR 2007.

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// Moves every pose but the roots (spanning_tree.h) to the chordal relaxation's. What the edges leave open, because an
/// information is singular, stays where the breadth-first tree puts it.
void PlaceByChordalRelaxation(Graph* graph, int threads = 1);

}  // namespace ch5
