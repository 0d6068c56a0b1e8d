#pragma once
/// Which block of H each edge touches: worked out once for a graph, so that an iteration only computes.
///
///   edges     those of landmark 0, of landmark 1, …, then those between poses, then those without free vertices
///   slots     one for each pair (landmark, free pose that shares an edge with it): a block of H_pm
///   products  one for each pair of free poses (or pose with itself) in an edge: J_iᵀJ_j is a part of block (i, j)
///
/// All linear parts of the edges live in one array: per edge its whitened residual, then a whitened Jacobian for each
/// free vertex, row after row, each row padded to Stride(dimension).

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/solve/block_matrix.h"

namespace ch5 {

/// A free vertex of an edge.
struct EdgeTerm {
  int position;  ///< in Edge::Vertices()
  int block;     ///< number of the pose, or of the landmark
  int slot;      ///< of a pose in an edge with a landmark, else −1
  int jacobian;  ///< where its Jacobian begins in the linear parts
};

struct EdgeRecord {
  Edge* edge;
  int rows;                    ///< residual dimension
  int residual;                ///< where the residual begins in the linear parts
  int terms_begin, terms_end;  ///< its free poses
  EdgeTerm landmark;           ///< block = −1 without a free landmark
};

/// J_aᵀJ_b of one edge, a and b ≤ a two of its free poses.
struct Product {
  int rows, jacobian_a, jacobian_b, residual;
};

struct BlockStructure {
  Ordering ordering;
  std::vector<Vertex*> poses, landmarks;
  std::vector<int> pose_dim, pose_offset;          ///< scalar rows in H_pp
  std::vector<int> landmark_dim, landmark_offset;  ///< scalar rows in H
  std::vector<int> landmark_block;                 ///< where the landmark's dim×dim block begins among those of H_mm

  std::vector<EdgeRecord> edges;  ///< in the order of the drawing above
  int num_active_edges = 0;       ///< those with a free vertex; they come first
  int num_landmark_edges = 0;     ///< those with a free landmark; they come first of all
  std::vector<EdgeTerm> terms;
  std::vector<int> landmark_edges;  ///< landmark l owns edges [landmark_edges[l], landmark_edges[l + 1])
  std::vector<int> landmark_slots;  ///< and slots [landmark_slots[l], landmark_slots[l + 1]), by ascending pose
  std::vector<int> slot_pose, slot_landmark;
  /// Where the slot's block, Stride(d_p)×d_m, begins among those of H_pm; and the end of all.
  std::vector<int> slot_block;
  std::vector<int> pose_slots_begin, pose_slots;  ///< the slots of each pose, by ascending landmark

  int num_linear_values = 0;  ///< length of the array of linear parts
  int num_H_mm_values = 0, num_H_pm_values = 0;

  std::vector<std::vector<int>> H_pp_pattern;  ///< rows i ≥ j of each column
  std::vector<Product> products;
  std::vector<int> products_begin;  ///< block k of H_pp is the sum of products [products_begin[k], …[k + 1])

  int Size() const { return ordering.Size(); }
};

/// Numbers the selected vertices of the graph (MakeOrdering) and finds the structure above.
/// @throws GraphError if an edge ties two free landmarks; both are named
BlockStructure BuildBlockStructure(const Graph& graph, const Selection& selection = {});

/// Rows i ≥ j of each column of the Schur complement, which ties all poses that see one landmark.
std::vector<std::vector<int>> SchurPattern(const BlockStructure& structure);

}  // namespace ch5
