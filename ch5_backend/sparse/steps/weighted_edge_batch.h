#pragma once
/// The landmarks' edges of a structure in batches (graph/fast_edge.h), one for each type of edge, whitened as in
/// graph/whitening.h. Measurements, losses and W are those at Assign, which SparseSolver calls in SetOrdering.

#include <algorithm>

#include "ch5_backend/graph/fast_edge.h"
#include "ch5_backend/graph/whitening.h"
#include "ch5_backend/sparse/kernels/jacobian.h"
#include "ch5_backend/sparse/steps/structure.h"

namespace ch5 {

/// Those of one type, numbered in the order in which they were added.
class WeightedEdgeBatch {
 public:
  static constexpr int kRows = 2;
  static constexpr int kMostVertices = 6;  ///< of an edge
  static constexpr int kMostColumns = 24;  ///< of all that Linearize gives of an edge together

  /// Makes it a batch for edges of this one's type; none is in it yet. Of a type without batches the edges go one by one into
  /// the lanes, unless their Jacobians are numeric: `first` is linearized to see that.
  /// @return false if the type has no batches of this kind, or not two rows
  bool Start(Edge* first, bool relative);
  /// Makes room for so many edges in all.
  void Reserve(size_t count) {
    capacity_ = count;
    batch_->Reserve(count);
  }
  /// @return false unless W = w I, and its sizes are those of the first
  bool Add(const Edge& edge);
  int Size() const { return size_; }

  /// Once before the two below, whenever the states have changed.
  void LoadPoses() { batch_->LoadPoses(); }
  /// ½ Σ ρ(rᵀWr) over edges [begin, end).
  double Cost(int begin, int end) const;
  /// r and J of edges [first, first + count), count ≤ kPack, as packs; J_i begins at number JacobianBegin(i). In a relative
  /// batch J_0 is that of the landmark and J_1 = J_ξ, see RelativeJacobians.
  void Linearize(int first, int count, double* r, double* J) const { batch_->Linearize(first, count, r, J); }
  /// r alone.
  void ComputeResiduals(int first, int count, double* r) const { batch_->ComputeResiduals(first, count, r); }
  int RelativeJacobians(int first, int count, RelativeJacobian* A) const {
    return batch_->RelativeJacobians(first, count, A);
  }
  /// s = rᵀWr of each lane, and, given these, ρ'(s) and wρ'(s); zero in lanes without an edge, but for ρ'.
  CH5_INLINE void Square(int first, int count, const double* r, double* s) const {
    alignas(64) double w[kPack];
    Weights(first, count, w);
    SquareNorms(w, r, s);
  }
  CH5_INLINE void Weigh(int first, int count, const double* s, double* slope, double* weight) const {
    alignas(64) double rank_one[kPack];
    WeighLosses(first, s, count, slope, rank_one);
    Weights(first, count, weight);
    *AsWide(weight) *= *AsWide(slope);
  }
  /// r̃ and J̃ of what Linearize has given, in its place; J̃ is zero in lanes without an edge. And s = rᵀWr of each lane.
  CH5_INLINE void Whiten(int first, int count, double* r, double* J, double* s) const;
  /// Σ ρ(s_k) of the edges from `first` on.
  double SumLosses(int first, const double* s, int count) const;
  int JacobianBegin(int position) const { return jacobian_begin_[position]; }
  int NumJacobians() const { return jacobian_begin_.back(); }  ///< numbers in all J_i of an edge
  int NumPositions() const { return static_cast<int>(jacobian_begin_.size()) - 1; }
  int Dimension(int position) const { return (jacobian_begin_[position + 1] - jacobian_begin_[position]) / kRows; }
  /// Where J_i begins, and the length of all, if each has Stride(dim) numbers a row.
  int BlockBegin(int position) const { return block_begin_[position]; }
  int BlocksSize() const { return block_begin_.back(); }

 private:
  // w and s = rᵀWr of edges [first, first + count), zero in lanes without an edge.
  CH5_INLINE void Weights(int first, int count, double* w) const {
    if (!unweighted_ && count == kPack) return void(*AsWide(w) = *AsWide(information_.data() + first));
    for (int k = 0; k < kPack; ++k) w[k] = k >= count ? 0.0 : unweighted_ ? 1.0 : information_[first + k];
  }
  CH5_INLINE void SquareNorms(const double* w, const double* r, double* s) const {
    const auto* lanes = AsWide(r);
    *AsWide(s) = *AsWide(w) * (lanes[0] * lanes[0] + lanes[1] * lanes[1]);
  }
  bool HasSizesOf(const Edge& edge) const;
  // CorrectLoss(s_k) of the edges from `first` on; in lanes without an edge it does not matter, as their w is 0.
  void WeighLosses(int first, const double* s, int count, double* weight, double* rank_one) const;

  std::shared_ptr<EdgeBatch> batch_;      // a copy of this shares it
  const std::type_info* type_ = nullptr;  // of the batch's edges
  Array<double> information_;             // w of each edge; none if unweighted_
  Array<const LossFunction*> losses_;
  Array<int> jacobian_begin_, block_begin_;
  int size_ = 0;
  size_t capacity_ = 0;
  bool unweighted_ = false, goes_one_by_one_ = false;
  const LossFunction* common_loss_ = nullptr;  // of all edges, or null
};

/// Those of all types, in the order of EdgeRecords::batch_edges: the functions below count them so.
class LandmarkEdgeBatches {
 public:
  static constexpr int kMostTypes = 3;

  /// Copies the structure's edges with a landmark. Packs them only if all blocks of H_pl have one of the fixed sizes, and the
  /// edges are of few types, each with batches, two rows and W = w I; otherwise Active() is false.
  void Assign(const Structure& structure);
  bool Active() const { return active_; }

  /// Like those of WeightedEdgeBatch; without effect where it is not active.
  void LoadPoses();
  double Cost(int begin, int end) const;

  /// Edge e is edge Number(e) of Batch(e).
  int Type(int e) const { return places_.empty() ? 0 : places_[e].type; }
  int Number(int e) const { return places_.empty() ? e : places_[e].number; }
  const WeightedEdgeBatch& Batch(int e) const { return batches_[Type(e)]; }
  int NumTypes() const { return active_ ? static_cast<int>(batches_.size()) : 0; }
  const WeightedEdgeBatch& OfType(int type) const { return batches_[type]; }

 private:
  struct Place {
    int type, number;
  };

  bool AddAll(const Structure& structure);

  Array<WeightedEdgeBatch> batches_;  // of each type
  Array<Place> places_;               // none if there is one type
  bool active_ = false;
};

CH5_INLINE void WeightedEdgeBatch::Whiten(int first, int count, double* r, double* J, double* s) const {
  alignas(64) double w[kPack], weight[kPack] = {}, rank_one[kPack] = {}, M[3][kPack] = {};
  Weights(first, count, w);
  SquareNorms(w, r, s);
  if (unweighted_ && count == kPack) return;
  WeighLosses(first, s, count, weight, rank_one);
  bool is_scalar = true;  // M = √(wρ') I, else M_00, M_01 = M_10, M_11
  for (int k = 0; k < kPack; ++k) is_scalar = is_scalar && rank_one[k] == 0.0;
  auto *r_lanes = AsWide(r), *J_lanes = AsWide(J);
  const auto* m = AsWide(M[0]);
  if (is_scalar) {
    for (int k = 0; k < kPack; ++k) M[0][k] = std::sqrt(w[k] * weight[k]);
    const WideLanes root = *m;
    for (int i = 0; i < kRows; ++i) r_lanes[i] *= root;
    for (int i = 0; i < NumJacobians(); ++i) J_lanes[i] *= root;
    return;
  }
  for (int k = 0; k < count; ++k) {
    const double r_k[kRows] = {r[k], r[kPack + k]};
    const TwoRowWhitening white(w[k], RobustWeight{weight[k], rank_one[k]}, r_k);
    for (int i = 0; i < kRows; ++i) r[i * kPack + k] = white.r[i];
    for (int i = 0; i < 3; ++i) M[i][k] = white.M[i / 2][(i + 1) / 2];
  }
  for (int i = 0; i < NumJacobians(); i += 2) {
    const WideLanes upper = J_lanes[i], lower = J_lanes[i + 1];
    J_lanes[i] = m[0] * upper + m[1] * lower;
    J_lanes[i + 1] = m[1] * upper + m[2] * lower;
  }
}

/// Eight of a batch's edges, linearized and whitened in the lanes of registers, then turned: each edge's J̃_i as a small
/// row-major matrix, its rows padded with zeros to whole Lanes.
class EdgePack {
 public:
  static constexpr int kRows = WeightedEdgeBatch::kRows;

  /// The place of the batch's edge e, which goes on one by one from wherever it begins.
  CH5_INLINE int LaneOf(const WeightedEdgeBatch& edges, int e) {
    if (e >= first_ + kPack || used_ == 0) Fill(edges, e);
    used_ = e - first_ + 1;
    return e - first_;
  }
  /// Σ ρ(s) of all edges that have been asked for.
  CH5_INLINE double SumOfLosses(const WeightedEdgeBatch& edges) const {
    return sum_of_losses_ + edges.SumLosses(first_, s_, used_);
  }
  /// r̃_i of the edge in a lane.
  CH5_INLINE double Residual(int lane, int i) const { return r_[i * kPack + lane]; }
  /// J̃ (kRows×dim, Stride(dim) numbers a row) of the edge in a lane for a vertex's position.
  CH5_INLINE double* Jacobian(const WeightedEdgeBatch& edges, int lane, int position) {
    return blocks_ + lane * edges.BlocksSize() + edges.BlockBegin(position);
  }

 private:
  CH5_INLINE void Fill(const WeightedEdgeBatch& edges, int e) {
    const int count = std::min(kPack, edges.Size() - e);
    sum_of_losses_ = SumOfLosses(edges);
    first_ = e;
    edges.Linearize(first_, count, r_, J_);
    edges.Whiten(first_, count, r_, J_, s_);
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
        kernels::Transpose(rows);
        CH5_UNROLL
        for (int k = 0; k < kLanes; ++k) *AsLanes(blocks + (first + k) * step + r * stride) = rows[k];
      }
    }
  }

  alignas(64) double r_[kRows * kPack];
  alignas(64) double J_[kRows * WeightedEdgeBatch::kMostColumns * kPack];
  alignas(64) double blocks_[kRows * WeightedEdgeBatch::kMostColumns * kLanes * kPack];
  alignas(64) double s_[kPack];
  double sum_of_losses_ = 0.0;  // of the packs before this one
  int first_ = 0, used_ = 0;    // edges of this one: the first, and how many have been asked for
};

}  // namespace ch5
