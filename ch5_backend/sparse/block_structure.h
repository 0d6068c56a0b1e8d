#pragma once
/// Which block of H each edge touches: worked out once for a graph, so that an iteration only computes.
///
///   landmarks  sorted by the poses that see them: neighbours in memory then share the blocks of S that they change
///   edges      those of landmark 0, of landmark 1, …, then those between poses, then those without free vertices
///   slots      one for each pair (landmark, free pose that shares an edge with it): a block of H_pm
///   chunks     of landmarks of about equal work: each sums its edges' parts of H_pp and b_p in memory of its own
///
/// An edge's own normal equations,  [J̃ r̃]ᵀ[J̃ r̃]  with the columns of its free poses by ascending block, then of its
/// landmark, then the residual, are a small square matrix:
///
///      ┌───────────────┐
///      │ J̃_pᵀJ̃_p       │      what is below the diagonal is what H and b want
///      │ J̃_lᵀJ̃_p  J̃_lᵀJ̃_l │
///      │ r̃ᵀJ̃_p   r̃ᵀJ̃_l  · │
///      └───────────────┘

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/linear/block_matrix.h"

namespace ch5 {

/// A free pose of an edge.
struct EdgeTerm {
  int position;  ///< in Edge::Vertices()
  int block;     ///< number of the pose
  int slot;      ///< if the edge has a landmark, else −1
  int column;    ///< its first column in the edge's normal equations
};

struct EdgeRecord {
  Edge* edge;
  int terms_begin, terms_end;  ///< its free poses, by ascending block
  int landmark_position;       ///< in Edge::Vertices(), or −1 without a free landmark
  int width;                   ///< columns of all free vertices together; the landmark's are the last
  int pairs;     ///< where the blocks of H_pp begin, in BlockStructure::pairs, that its poses i and j ≤ i share
  int products;  ///< of an edge between poses: where its normal equations are kept
};

/// A part of block (i, j) of H_pp: a block of the normal equations of an edge between poses.
struct Product {
  int values;  ///< where it begins
  int stride;  ///< from column to column
  int rhs;     ///< of a diagonal block: where r̃ᵀJ̃_j begins, in steps of `stride`; else −1
};

/// Edges and vertices are scattered over memory, where no processor guesses them: asks for one that is needed soon.
inline void PrefetchObject(const void* object, int lines) {
  for (int line = 0; line < lines; ++line) __builtin_prefetch(static_cast<const char*>(object) + 64 * line);
}
inline void PrefetchEdge(const std::vector<EdgeRecord>& edges, int e) {
  if (e < static_cast<int>(edges.size())) PrefetchObject(edges[e].edge, 4);
}

struct BlockStructure {
  Ordering ordering;  ///< its incidence has been used up
  std::vector<Vertex*> poses, landmarks;
  std::vector<int> pose_dim, pose_offset;          ///< scalar rows in H_pp
  std::vector<int> landmark_dim, landmark_offset;  ///< scalar rows in H
  std::vector<int> landmark_block;                 ///< where the landmark's dim×dim block begins among those of H_mm

  std::vector<EdgeRecord> edges;  ///< in the order of the drawing above
  int num_active_edges = 0;       ///< those with a free vertex; they come first
  int num_landmark_terms = 0;     ///< of edges with a free landmark
  int num_landmark_edges = 0;     ///< those with a free landmark; they come first of all
  std::vector<EdgeTerm> terms;
  std::vector<int> landmark_edges;  ///< landmark l owns edges [landmark_edges[l], landmark_edges[l + 1])
  std::vector<int> landmark_slots;  ///< and slots [landmark_slots[l], landmark_slots[l + 1]), by ascending pose
  std::vector<int> slot_pose, slot_landmark;
  /// Where the slot's block, d_p×d_m without padding, begins among those of H_pm; and the end of all.
  std::vector<int> slot_block;
  std::vector<int> pose_slots_begin, pose_slots;  ///< the slots of each pose, by ascending landmark

  std::vector<int> chunk_begin;  ///< chunk c owns landmarks [chunk_begin[c], chunk_begin[c + 1])

  int num_product_values = 0;  ///< length of the array of kept normal equations
  int max_width = 0;           ///< of an edge's free columns
  int max_rows = 0;            ///< of a residual
  int num_H_mm_values = 0, num_H_pm_values = 0;

  std::vector<std::vector<int>> H_pp_pattern;  ///< rows i ≥ j of each column
  std::vector<int> pairs;                      ///< blocks of H_pp, see EdgeRecord
  std::vector<Product> products;
  std::vector<int> products_begin;  ///< block k of H_pp is the sum of products [products_begin[k], …[k + 1])

  int Size() const { return ordering.Size(); }
  /// No landmark shares two edges with the same pose, as in plain bundle adjustment: an edge then is all of its slots.
  bool OneEdgePerSlot() const { return num_landmark_terms == static_cast<int>(slot_pose.size()); }
};

/// Finds the structure above for an ordering that MakeOrdering has just made.
/// @throws GraphError if an edge ties two free landmarks; both are named
BlockStructure BuildBlockStructure(Ordering ordering);

/// Rows i ≥ j of each column of the Schur complement, which ties all poses that see one landmark.
std::vector<std::vector<int>> SchurPattern(const BlockStructure& structure);

}  // namespace ch5
