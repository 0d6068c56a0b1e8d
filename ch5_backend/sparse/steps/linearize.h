#pragma once
/// The normal equations at the present states:
///
///   H = Σ J̃ᵀJ̃,   b = −Σ J̃ᵀr̃                                     r̃, J̃: graph/whitening.h;  Triggs (2000), §4.3
///
///      ┌───────┬──────┐        H_pp  sparse blocks: poses that share an edge
///      │ H_pp  │ H_pl │        H_pl  a block for each slot (landmark, pose that sees it)
///      ├───────┼──────┤        H_ll  block diagonal, so that its inverse is cheap
///      │ H_plᵀ │ H_ll │
///      └───────┴──────┘
///
/// Chunk by chunk, the edges of the landmarks are linearized, run by run or landmark by landmark: a landmark's blocks of
/// H_ll, H_pl and b_l are then complete, and its part of H_pp, b_p and the cost goes to sums of the chunk's own. Then
/// each column of H_pp adds up these sums. The edges between poses follow, batch by batch: a batch is linearized, and each
/// thread adds what belongs to its own columns. All is added in the order of the structure: the result is the same
/// to the bit for any number of threads.

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/kernels/landmark.h"
#include "ch5_backend/sparse/steps/edge_normal_equations.h"
#include "ch5_backend/sparse/steps/weighted_edge_batch.h"

namespace ch5 {

struct Linearized {
  SymmetricBlockMatrix H_pp;
  AlignedVector H_pl;         ///< see Slots::SlotBlock; or empty, and then
  Array<float> H_pl_factors;  ///< of each slot's block, kernels/slot_factors.h
  AlignedVector H_ll;         ///< see Numbering::landmark_block
  VecX b;                     ///< all rows, poses first

  /// Memory that Linearize works in: the columns of H_pp, and b_p, of the poses that see a chunk's landmarks.
  struct PoseSums {
    AlignedVector H_pp, b;   ///< each column laid out as in H_pp; `b_stride` numbers a pose. One chunk alone sums
                             ///< its H_pp in that of the whole
    double cost = 0.0;       ///< of the chunk's edges
    Array<int> number;       ///< of each pose in b, or −1
    Array<ptrdiff_t> shift;  ///< of each column: from its values in H_pp to those here
  };
  Array<PoseSums> chunk_sums;
  int b_stride = 0;
  void ResizeChunkSums(const Structure& structure);
  AlignedVector normal_equations;  ///< of the edges of one batch between poses, negative
  Array<double> other_costs;       ///< sums over edges without a free landmark

  /// Takes all memory for this structure.
  /// @param factored  H_pl by its factors, which only products with it want: Structure::OnePoseAnEdge, active batches
  void Resize(const Structure& structure, bool factored = false);
  /// What the kernels need of the poses that see landmark `l`.
  kernels::LandmarkSlots Slots(const Structure& s, int l) const {
    return {s.landmark_slots[l],
            s.landmark_slots[l + 1],
            s.slot_pose.data(),
            s.slot_block.empty() ? nullptr : s.slot_block.data(),
            s.SlotSize(),
            s.pose_offset.data(),
            s.pose_dim.data(),
            H_pl.data(),
            H_pl_factors.empty() ? nullptr : H_pl_factors.data()};
  }
  /// The block of H_pl that belongs to a slot.
  MatXX Coupling(const Structure& s, int slot) const;
  /// Calls function(row, column, block) for each block of H that is stored: those off the diagonal are on one side of it.
  template <typename Function>
  void ForEachBlock(const Structure& s, const Function& function) const;
};

template <typename Function>
void Linearized::ForEachBlock(const Structure& s, const Function& function) const {
  for (int j = 0; j < s.NumPoses(); ++j) {
    for (int block = H_pp.ColumnBegin(j); block < H_pp.ColumnBegin(j + 1); ++block) {
      const int i = H_pp.Row(block);
      const Eigen::Map<const MatXX> padded(H_pp.Values(block), Stride(s.pose_dim[i]), s.pose_dim[j]);
      function(s.pose_offset[i], s.pose_offset[j], padded.topRows(s.pose_dim[i]));
    }
  }
  for (int l = 0; l < s.NumLandmarks(); ++l) {
    const int dim = s.landmark_dim[l], column = s.landmark_offset[l];
    function(column, column, Eigen::Map<const MatXX>(&H_ll[s.landmark_block[l]], dim, dim));
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      function(s.pose_offset[s.slot_pose[slot]], column, Coupling(s, slot));
    }
  }
}

/// Fills H and b. @return the cost, ½ Σ ρ(rᵀWr) over all edges: Cost of the solver but for rounding
/// @param batches  the landmarks' edges where they fit into some, their poses just loaded; otherwise they are not active
/// @param pool   of one thread if an edge has numeric Jacobians, which move the vertices
double Linearize(const Structure& structure, const LandmarkEdgeBatches& batches, ThreadPool* pool, Linearized* system);

}  // namespace ch5
