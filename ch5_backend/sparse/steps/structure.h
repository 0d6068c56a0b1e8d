#pragma once
/// What lies where: which block of H each edge touches, found once for a graph, so that an iteration only computes.
///
///   landmarks  sorted by the poses that see them: neighbors in memory then change the same blocks of S
///   edges      those of landmark 0, of landmark 1, …, then those between poses, then those without free vertices
///   slots      one for each landmark and free pose that sees it: a block of H_pl
///   chunks     of landmarks, of about equal work, each the work of one task
///
/// An edge's own normal equations  [J̃ r̃]ᵀ[J̃ r̃]  are a small square matrix. Its columns are those of the free poses by
/// ascending number, then of the landmark, then the residual (of an edge between poses: those of all its vertices in its
/// own order, then the residual):
///
///      ┌───────────────┐
///      │ J̃_pᵀJ̃_p       │      H and b take what is on and below the diagonal
///      │ J̃_lᵀJ̃_p  J̃_lᵀJ̃_l │
///      │ r̃ᵀJ̃_p   r̃ᵀJ̃_l  · │
///      └───────────────┘

#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/linear/block_matrix.h"
#include "ch5_backend/math/dispatch.h"

namespace ch5 {

/// A free pose of an edge.
struct EdgePose {
  int position;  ///< in Edge::Vertices()
  int pose;      ///< its number
  int slot;      ///< if the edge has a free landmark, else −1
  int column;    ///< its first column in the edge's normal equations
};

/// An edge, and where its blocks are stored.
struct EdgeRecord {
  Edge* edge;
  int poses_begin, poses_end;  ///< its free poses in EdgeRecords::edge_poses, by ascending number
  int landmark_position;       ///< in Edge::Vertices(), or −1 without a free landmark
  int width;                   ///< columns of J̃ in the edge's normal equations
  int blocks_begin;            ///< its blocks of H_pp in PoseBlocks::edge_blocks: (0, 0), (1, 0), (1, 1), (2, 0), …
  int normal_equations;        ///< of an edge between poses: where its normal equations begin among those of its batch
  int landmark = -1;           ///< its number
  int16_t type = 0;            ///< of an edge with a free landmark: counts their types
  bool is_numeric = false;     ///< it is linearized before the others (numeric_edges.h)
};

/// Landmarks' edges of one type with the same free poses at the same positions: they change the same blocks of H_pp.
struct EdgeRun {
  int begin, end;  ///< of EdgeRecords::batch_edges
};

/// Which number each free vertex has, and where its rows are.
struct Numbering {
  Ordering ordering;  ///< its incidence has been moved out
  Array<Vertex*> poses, landmarks;
  Array<int> pose_dim, pose_offset;          ///< scalar rows in H_pp
  Array<int> landmark_dim, landmark_offset;  ///< scalar rows in H
  Array<int> landmark_block;                 ///< where the landmark's dim×dim block begins among those of H_ll
  int num_H_ll_values = 0;

  int Size() const { return ordering.Size(); }
  int NumPoses() const { return static_cast<int>(poses.size()); }
  int NumLandmarks() const { return static_cast<int>(landmarks.size()); }
};

/// The blocks of H_pl.
struct Slots {
  BlockSizes sizes;           ///< of these blocks, where all have the same
  Array<int> landmark_slots;  ///< landmark l has slots [landmark_slots[l], landmark_slots[l + 1]), by ascending pose
  Array<int> slot_pose, slot_landmark;
  Array<int> slot_block;  ///< SlotBlock of each slot and of the end, unless all have the same size
  Lists pose_slots;       ///< the slots of each pose, by ascending landmark
  int num_H_pl_values = 0;

  /// Where the slot's block, d_p×d_l without padding, begins among those of H_pl; that of the end is behind all.
  int SlotBlock(int slot) const { return slot_block.empty() ? slot * SlotSize() : slot_block[slot]; }
  /// The numbers of each block, where all have the same size.
  int SlotSize() const { return sizes.AreFixed() ? sizes.rows * sizes.columns : 0; }
  /// See EdgeRecords::batch_edges.
  bool BatchGoesByRuns() const { return sizes.AreFixed() && sizes.columns == 1; }
};

/// The edges, in the order above, and which free poses and landmark each has.
struct EdgeRecords {
  Array<EdgeRecord> edges;
  int num_landmark_edges = 0;  ///< those with a free landmark; they come first
  int num_active_edges = 0;    ///< those with any free vertex; they come before the others
  Array<EdgePose> edge_poses;
  int num_landmark_edge_poses = 0;  ///< of the edges with a free landmark
  Array<int> landmark_edges;        ///< landmark l has edges [landmark_edges[l], landmark_edges[l + 1])
  /// The landmarks' edges in the order of a batch: by their poses in each chunk where a landmark is a number, as they are
  /// where it is a point (then there are few with the same poses, and the list is empty).
  Array<int> batch_edges;
  int num_edge_types = 0;  ///< of the landmarks' edges
  int max_width = 0;       ///< of an edge's J̃
  int max_rows = 0;        ///< of a residual

  /// Edge k in the order of a batch, those between poses behind.
  int BatchEdge(int k) const { return k < static_cast<int>(batch_edges.size()) ? batch_edges[k] : k; }
};

/// The blocks of H_pp, and the edges between poses, which change nothing else.
struct PoseBlocks {
  Lists H_pp_pattern;      ///< rows i ≥ j of each column
  Array<int> edge_blocks;  ///< numbers of blocks of H_pp, see EdgeRecord
  /// Edges between poses, in batches whose normal equations stay in a processor's cache until they have been added to H_pp:
  /// batch k has edges [pose_batches[k], pose_batches[k + 1]).
  Array<int> pose_batches;
  int num_normal_equation_values = 0;  ///< of the largest batch
};

/// The landmarks, cut into the work of tasks.
struct Chunks {
  Array<int> chunk_begin;  ///< chunk c has landmarks [chunk_begin[c], chunk_begin[c + 1])
  Array<EdgeRun> runs;     ///< none if the batch's edges stay as they are
  Array<int> chunk_runs;   ///< chunk c has runs [chunk_runs[c], chunk_runs[c + 1])

  int NumChunks() const { return chunk_begin.empty() ? 0 : static_cast<int>(chunk_begin.size()) - 1; }
  /// One chunk alone needs no sums of its own: it adds to H_pp itself.
  bool SumsInPlace() const { return NumChunks() == 1; }
};

/// All of them: a step reads `structure.slot_pose`, whichever part it is of; what needs one part alone takes that.
struct Structure : Numbering, Slots, EdgeRecords, PoseBlocks, Chunks {
  /// No landmark has two edges with the same pose, as in plain bundle adjustment: each slot is then one edge's work.
  bool OneEdgePerSlot() const { return num_landmark_edge_poses == static_cast<int>(slot_pose.size()); }
  /// Besides, no landmark's edge has two free poses: each block of H_pl is then a product of one edge's Jacobians.
  bool OnePoseAnEdge() const;
};

/// Finds the structure above for an ordering that MakeOrdering has just made.
/// @throws GraphError if an edge ties two free landmarks; both are named
Structure BuildStructure(Ordering ordering);

/// Numbers the poses that see the landmarks [begin, end), ascending; −1 for all others. A task that sums over these landmarks
/// needs memory for these poses alone: in a city they are few.
Array<int> NumberPosesOfLandmarks(const Structure& structure, int begin, int end);

/// Prefetches an object that is needed soon: edges and vertices are scattered, so hardware prefetching does not help.
inline void PrefetchObject(const void* object, int lines) {
  for (int line = 0; line < lines; ++line) __builtin_prefetch(static_cast<const char*>(object) + 64 * line);
}
/// Edge `e`, if there is one.
inline void PrefetchEdge(const Array<EdgeRecord>& edges, int e) {
  if (e < static_cast<int>(edges.size())) PrefetchObject(edges[e].edge, 4);
}

}  // namespace ch5
