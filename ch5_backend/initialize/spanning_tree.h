#pragma once
/// A start for a pose graph: from the fixed poses outward, along a tree of edges.
///
///   T_W_j = T_W_i T_i_j   along an edge i → j,      T_W_i = T_W_j T_i_j⁻¹   against it
///
///   0 ──► 1 ──► 2     breadth first, from 0: as few edges as there are, 3 by way of 1, and 4 from 0
///   │     │     │     odometry first: along the path 0 ► 1 ► 2 ► 3 ► 4, whose errors add up
///   4 ◄── 3 ◄───┘

#include <memory>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// The number of poses before each of the graph's vertices: those whose numbers follow each other are a path, landmarks between
/// or not.
std::vector<int> NumberPoses(const Graph& graph);

/// kBreadthFirst takes the fewest edges from a root to each pose. kOdometryFirst takes all edges between poses that follow
/// each other in the graph, the first of several, and others only where these do not reach.
enum class TreeOrder { kBreadthFirst, kOdometryFirst };

/// The poses from which all others that have an edge can be reached: those that are fixed, and the first one of each part
/// without. Only edges with a measured transform count (types/pose_graph/as_transform.h).
std::vector<std::shared_ptr<Vertex>> FindRoots(const Graph& graph);

/// The edges of the tree, each of which leads to one pose.
std::vector<const Edge*> TreeEdges(TreeOrder order, const Graph& graph);

/// Moves every pose but the roots to where its tree puts it.
void PlaceAlongTree(TreeOrder order, Graph* graph);

}  // namespace ch5
