#include "ch5_backend/solve/packed_edges.h"

#include <algorithm>
#include <typeinfo>

namespace ch5 {

void PackedEdges::Assign(const BlockStructure& s) {
  active_ = false;
  if (s.num_landmark_edges == 0) return;
  const Edge& first = *s.edges[0].edge;
  if (!type_ || *type_ != typeid(first)) batch_ = first.MakeBatch();
  type_ = &typeid(first);
  if (!batch_) return;

  jacobian_begin_.assign(1, 0);
  block_begin_.assign(1, 0);
  for (const auto& vertex : first.Vertices()) {
    jacobian_begin_.push_back(jacobian_begin_.back() + kRows * vertex->LocalDimension());
    block_begin_.push_back(block_begin_.back() + kRows * Stride(vertex->LocalDimension()));
  }
  if (first.ResidualDimension() != kRows || NumJacobians() > kRows * kMostColumns) return;

  batch_->Clear();
  weights_.clear();
  unweighted_ = true;
  constexpr int kAhead = 12;
  for (int e = 0; e < s.num_landmark_edges; ++e) {
    PrefetchEdge(s.edges, e + kAhead);
    const Edge& edge = *s.edges[e].edge;
    const Weight weight{edge.IsotropicInformation(), edge.GetLossFunction()};
    if (typeid(edge) != *type_ || weight.information < 0.0) return;
    batch_->Add(edge);
    if (unweighted_ && (weight.information != 1.0 || weight.loss)) {
      unweighted_ = false;
      weights_.reserve(static_cast<size_t>(s.num_landmark_edges));
      weights_.assign(static_cast<size_t>(e), {1.0, nullptr});
    }
    if (!unweighted_) weights_.push_back(weight);
  }
  active_ = true;
}

double PackedEdges::RobustChi2(int begin, int end) const {
  alignas(64) double r[kRows * kPack];
  double sum = 0.0;
  for (int first = begin; first < end; first += kPack) {
    const int count = std::min(kPack, end - first);
    batch_->ComputeResiduals(first, count, r);
    for (int k = 0; k < count; ++k) {
      const double square = r[k] * r[k] + r[kPack + k] * r[kPack + k];
      if (unweighted_) {
        sum += square;
        continue;
      }
      const double s = weights_[first + k].information * square;
      const LossFunction* loss = weights_[first + k].loss;
      sum += loss ? loss->Evaluate(s)[0] : s;
    }
  }
  return sum;
}

}  // namespace ch5
