#pragma once
/// Where the optimization of a pose graph begins. Its cost has many minima: what is found depends on the start.

#include <utility>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// Where the optimization of a pose graph begins.
enum class PoseGraphStart {
  kGiven,         ///< the poses as they are
  kOdometry,      ///< along the path: spanning_tree.h
  kSpanningTree,  ///< along the tree with the fewest edges from the fixed pose: spanning_tree.h
  kChordal,       ///< chordal relaxation: chordal.h; in the plane LAGO: planar.h
  kIncremental    ///< pose after pose, with solutions in between: incremental.h
};

/// The starts by name, in the order above.
inline constexpr std::pair<const char*, PoseGraphStart> kPoseGraphStartNames[] = {
    {"file", PoseGraphStart::kGiven},
    {"odometry", PoseGraphStart::kOdometry},
    {"spanning-tree", PoseGraphStart::kSpanningTree},
    {"chordal", PoseGraphStart::kChordal},
    {"incremental", PoseGraphStart::kIncremental},
};

/// Moves every free pose that a measured transform leads to, and then the free landmarks to where the poses see them.
/// @throws GraphError if the graph is null
void InitializePoseGraph(PoseGraphStart start, Graph* graph, int threads = 1);

/// The start with the least cost ½ Σ ρ(rᵀWr), the first one if several have it.
/// @param starts  those to be tried; kGiven is the state at the time of the call
/// @return the cost of each, in the order of `starts`; the graph is left at the best
/// @throws GraphError if the graph is null
std::vector<double> InitializeAtLeastCost(const std::vector<PoseGraphStart>& starts, Graph* graph, int threads = 1);

}  // namespace ch5
