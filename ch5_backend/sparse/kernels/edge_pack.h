#pragma once
/// Eight of a batch's edges, linearised and whitened in the lanes of registers, then turned: each edge's J̃_i as a small
/// row-major matrix, its rows padded with zeros to whole Lanes.

#include <algorithm>

#include "ch5_backend/sparse/kernels/blocks.h"
#include "ch5_backend/sparse/weighted_edge_batch.h"

namespace ch5::kernels {

class EdgePack {
 public:
  static constexpr int kRows = WeightedEdgeBatch::kRows;

  /// Of the edges [begin, end) it will hold eight after eight.
  EdgePack(int begin, int end) : next_(begin), end_(end) {}

  /// Edge e's place; e goes from begin to end, one by one.
  CH5_INLINE int LaneOf(const WeightedEdgeBatch& edges, int e) {
    if (e == next_) Fill(edges);
    return e - first_;
  }
  /// r̃_i of the edge in a lane.
  CH5_INLINE double Residual(int lane, int i) const { return r_[i * kPack + lane]; }
  /// J̃ (kRows×dim, Stride(dim) numbers a row) of the edge in a lane for a vertex's position.
  CH5_INLINE const double* Jacobian(const WeightedEdgeBatch& edges, int lane, int position) const {
    return blocks_ + lane * edges.BlocksSize() + edges.BlockBegin(position);
  }

 private:
  CH5_INLINE void Fill(const WeightedEdgeBatch& edges) {
    const int count = std::min(kPack, end_ - next_);
    first_ = next_;
    next_ += count;
    edges.Linearize(first_, count, r_, J_);
    edges.Whiten(first_, count, r_, J_);
    for (int i = 0; i < edges.NumPositions(); ++i) {
      Turn(J_ + edges.JacobianBegin(i) * kPack, edges.Dimension(i), edges.BlocksSize(), blocks_ + edges.BlockBegin(i));
    }
  }

  // The lanes of J's numbers (column-major) become matrices, `step` numbers from one edge's to the next one's.
  static CH5_INLINE void Turn(const double* J, int dim, int step, double* blocks) {
    for (int c = 0; c < dim; c += kLanes, J += kLanes * kRows * kPack, blocks += kLanes) {
      switch (dim - c) {
        case 1: TurnColumns<1>(J, Stride(dim), step, blocks); break;
        case 2: TurnColumns<2>(J, Stride(dim), step, blocks); break;
        case 3: TurnColumns<3>(J, Stride(dim), step, blocks); break;
        default: TurnColumns<4>(J, Stride(dim), step, blocks);
      }
    }
  }
  template <int Columns>
  static CH5_INLINE void TurnColumns(const double* J, int stride, int step, double* blocks) {
    CH5_UNROLL
    for (int r = 0; r < kRows; ++r) {
      for (int first = 0; first < kPack; first += kLanes) {
        Lanes rows[kLanes] = {};
        CH5_UNROLL
        for (int k = 0; k < Columns; ++k) rows[k] = *AsLanes(J + (k * kRows + r) * kPack + first);
        Transpose(rows);
        CH5_UNROLL
        for (int k = 0; k < kLanes; ++k) *AsLanes(blocks + (first + k) * step + r * stride) = rows[k];
      }
    }
  }

  alignas(64) double r_[kRows * kPack];
  alignas(64) double J_[kRows * WeightedEdgeBatch::kMostColumns * kPack];
  alignas(64) double blocks_[kRows * WeightedEdgeBatch::kMostColumns * kLanes * kPack];
  int first_ = 0, next_, end_;  // edges
};

}  // namespace ch5::kernels
