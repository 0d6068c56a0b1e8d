#pragma once
/// The landmarks' edges of a structure as one batch (graph/edge_batch.h), whitened as in linear_parts.h. Measurements,
/// losses and W are those at Assign, which BlockSolver calls in SetOrdering.

#include "ch5_backend/solve/linear_parts.h"

namespace ch5 {

class PackedEdges {
 public:
  static constexpr int kRows = 2;
  static constexpr int kMostColumns = 16;  ///< of all vertices of an edge together

  /// Copies the structure's edges with a landmark, in its order. Packs them only if all are of one type that has
  /// batches, with two rows and W = w I; otherwise Active() is false.
  void Assign(const BlockStructure& structure);
  void Clear() { active_ = false; }
  bool Active() const { return active_; }

  /// Once before the two below, whenever the states have changed.
  void LoadPoses() { batch_->LoadPoses(); }
  /// Σ ρ(rᵀWr) over edges [begin, end).
  double RobustChi2(int begin, int end) const;
  /// r and J of edges [first, first + count), count ≤ kPack, as packs; J_i begins at number JacobianBegin(i).
  void Linearize(int first, int count, double* r, double* J) const { batch_->Linearize(first, count, r, J); }
  int JacobianBegin(int position) const { return jacobian_begin_[position]; }
  int NumJacobians() const { return jacobian_begin_.back(); }  ///< numbers in all J_i of an edge
  int NumPositions() const { return static_cast<int>(jacobian_begin_.size()) - 1; }
  int Dimension(int position) const { return (jacobian_begin_[position + 1] - jacobian_begin_[position]) / kRows; }
  /// Where J_i begins, and the length of all, if each has Stride(dim) numbers a row.
  int BlockBegin(int position) const { return block_begin_[position]; }
  int BlocksSize() const { return block_begin_.back(); }

  /// w, and the loss or null, of edge e, unless Unweighted().
  double Information(int e) const { return weights_[e].information; }
  const LossFunction* Loss(int e) const { return weights_[e].loss; }
  /// True if W = I and there is no loss, for all edges.
  bool Unweighted() const { return unweighted_; }

 private:
  struct Weight {
    double information;
    const LossFunction* loss;
  };

  std::shared_ptr<EdgeBatch> batch_;      // a copy of this shares it
  const std::type_info* type_ = nullptr;  // of the batch's edges
  std::vector<Weight> weights_;           // none if unweighted_
  std::vector<int> jacobian_begin_, block_begin_;
  bool active_ = false, unweighted_ = false;
};

}  // namespace ch5
