#pragma once
/// Landmarks of a pose graph for given poses, each by itself: one linear problem of 2 or 3 unknowns.
///
///   min Σ ‖r + J δ‖²_W   over the edges that see it;   of a bearing r = nᵀ(l − p), the distance from its ray

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// Moves the landmark, vertex 1 of these edges, to where they see it.
void PlaceLandmark(const std::vector<std::shared_ptr<Edge>>& edges, Vertex* landmark);

/// Moves every free landmark that an edge from a pose sees. What its edges leave open, such as the distance along a single
/// bearing, stays as it is.
void PlaceLandmarks(Graph* graph);

}  // namespace ch5
