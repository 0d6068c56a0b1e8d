#pragma once
/// Which rows each vertex has in H and b: poses first, landmarks last.
///
///        poses   landmarks
///      ┌───────┬─────────┐
///      │ H_pp  │  H_pl   │  dim_poses
///      ├───────┼─────────┤
///      │ H_plᵀ │  H_ll   │  dim_landmarks   (block diagonal)
///      └───────┴─────────┘

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/math/array_memory.h"

namespace ch5 {

/// Which part of a graph is optimized (g2o's initializeOptimization).
struct Selection {
  int level = 0;                                  ///< edges of this level, or of all levels if it is negative
  bool all_vertices = true;                       ///< or only those below
  std::vector<std::shared_ptr<Vertex>> vertices;  ///< an edge is selected only if all its vertices are among them
};

/// A part of a vertex that stays as it is, such as position and yaw of a pose, or biases: directions with C δ = 0.
struct HeldDirections {
  std::shared_ptr<Vertex> vertex;  ///< not a landmark
  std::function<MatXX()> rows;     ///< C at the present states, k×LocalDimension(), of rank k ≥ 1
};

/// The free vertices of each edge as one array of numbers: asking every edge would read scattered memory.
struct Incidence {
  /// One free vertex of an edge.
  struct Entry {
    int position;  ///< in Edge::Vertices()
    int number;    ///< of the pose; the landmarks are numbered after the poses
  };
  Array<int> begin{0};  ///< edge e of the ordering has entries [begin[e], begin[e + 1])
  Array<Entry> entries;
  int max_residual_dimension = 0;

  /// Adds the next edge. Its vertices' OrderingIds are their numbers meanwhile, −1 of those that are not free.
  void Append(const Edge& edge) {
    max_residual_dimension = std::max(max_residual_dimension, edge.ResidualDimension());
    int position = 0;
    for (const auto& vertex : edge.Vertices()) {
      if (vertex->OrderingId() >= 0) entries.push_back({position, vertex->OrderingId()});
      ++position;
    }
    begin.push_back(static_cast<int>(entries.size()));
  }
};

struct Ordering {
  int dim_poses = 0;
  int dim_landmarks = 0;
  std::vector<std::shared_ptr<Vertex>> poses;      ///< free vertices in the order of their rows
  std::vector<std::shared_ptr<Vertex>> landmarks;  ///< likewise; rows begin at dim_poses
  /// The selected edges, in order of id. One whose vertices are all fixed adds a constant to the cost and nothing to H
  /// and b: it is not active.
  std::vector<std::shared_ptr<Edge>> edges;
  Incidence incidence;
  int Size() const { return dim_poses + dim_landmarks; }
  /// Forgets all, and keeps the memory.
  void Clear() {
    dim_poses = dim_landmarks = 0;
    poses.clear();
    landmarks.clear();
    edges.clear();
    incidence = {};
  }
};

/// Gives every free vertex that has a selected edge its OrderingId, in order of id within each role; the others get −1:
/// a fixed vertex has no columns, and a vertex without edges would leave H with a zero row.
/// @param used  an ordering that is needed no more: its memory serves this one
Ordering MakeOrdering(const Graph& graph, const Selection& selection = {}, Ordering used = {});

/// @throws GraphError if a vertex or an edge of it has left the graph, or a vertex has been renumbered
void CheckOrdering(const Ordering& ordering);

/// x ← x ⊞ δ of all free vertices, which remember x; RollBack undoes the last Update to the bit.
void Update(const Ordering& ordering, const VecX& delta_x);
void RollBack(const Ordering& ordering);
/// ‖x‖ over the free vertices.
double StateNorm(const Ordering& ordering);

/// Linearizes the edges. @return "TYPE ID has a residual or a Jacobian that is not finite" for the first such edge, or ""
std::string WhatIsNotFinite(const std::vector<std::shared_ptr<Edge>>& edges);

/// The number of the free landmark of each edge, or −1 if it has none.
/// @throws GraphError if an edge has two: H_ll would then not be block diagonal, as eliminating a landmark must not
///         affect another. Both are named.
Array<int> LandmarkOfEachEdge(const Ordering& ordering);

}  // namespace ch5
