#pragma once
/// Where each vertex lives in H and b: poses first, landmarks last.
///
///        poses   landmarks
///      ┌───────┬─────────┐
///      │ H_pp  │  H_pm   │  dim_poses
///      ├───────┼─────────┤
///      │ H_mp  │  H_mm   │  dim_landmarks   (block diagonal)
///      └───────┴─────────┘

#include <memory>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

struct Ordering {
  int dim_poses = 0;
  int dim_landmarks = 0;
  std::vector<std::shared_ptr<Vertex>> poses;      ///< free vertices in the order of their rows
  std::vector<std::shared_ptr<Vertex>> landmarks;  ///< likewise; rows begin at dim_poses
  int Size() const { return dim_poses + dim_landmarks; }
};

/// Gives every free vertex that has an edge its OrderingId, in order of id within each role; the others get −1: a
/// fixed vertex has no columns, and a vertex without edges would leave H with a zero row.
Ordering MakeOrdering(const Graph& graph);

}  // namespace ch5
