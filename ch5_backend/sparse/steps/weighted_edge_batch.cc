#include "ch5_backend/sparse/steps/weighted_edge_batch.h"

#include <algorithm>
#include <typeinfo>

namespace ch5 {

void WeightedEdgeBatch::Assign(const Structure& s) {
  active_ = false;
  if (s.num_landmark_edges == 0) return;
  const Edge& first = *s.edges[0].edge;
  if (!type_ || *type_ != typeid(first)) batch_ = AsFast(first) ? AsFast(first)->MakeBatch() : nullptr;
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
  information_.clear();
  losses_.clear();
  unweighted_ = true;
  common_loss_ = first.GetLossFunction();
  constexpr int kAhead = 12, kLines = 6;  // whole edges, with what their batch copies
  for (int e = 0; e < s.num_landmark_edges; ++e) {
    if (e + kAhead < s.num_landmark_edges) PrefetchObject(s.edges[s.batch_edges[e + kAhead]].edge, kLines);
    const Edge& edge = *s.edges[s.batch_edges[e]].edge;
    const double information = edge.IsotropicInformation();
    const LossFunction* loss = edge.GetLossFunction();
    if (typeid(edge) != *type_ || information < 0.0) return;
    batch_->Add(edge);
    if (loss != common_loss_) common_loss_ = nullptr;
    if (unweighted_ && (information != 1.0 || loss)) {
      unweighted_ = false;
      information_.reserve(static_cast<size_t>(s.num_landmark_edges));
      losses_.reserve(static_cast<size_t>(s.num_landmark_edges));
      information_.assign(static_cast<size_t>(e), 1.0);
      losses_.assign(static_cast<size_t>(e), nullptr);
    }
    if (unweighted_) continue;
    information_.push_back(information);
    losses_.push_back(loss);
  }
  active_ = true;
}

double WeightedEdgeBatch::Cost(int begin, int end) const {
  constexpr int kAtOnce = 8 * kPack;
  alignas(64) double r[kRows * kPack], w[kPack], s[kAtOnce];
  double sum = 0.0;
  for (int start = begin; start < end; start += kAtOnce) {
    const int num = std::min(kAtOnce, end - start);
    for (int k = 0; k < num; k += kPack) {
      const int count = std::min(kPack, num - k);
      batch_->ComputeResiduals(start + k, count, r);
      Weights(start + k, count, w);
      SquareNorms(w, r, s + k);
    }
    sum += SumLosses(start, s, num);
  }
  return 0.5 * sum;
}

double WeightedEdgeBatch::SumLosses(int first, const double* s, int count) const {
  if (common_loss_) return common_loss_->Sum(s, count);
  double sum = 0.0;
  for (int k = 0; k < count; ++k) {
    const LossFunction* loss = unweighted_ ? nullptr : losses_[first + k];
    sum += loss ? loss->Evaluate(s[k])[0] : s[k];
  }
  return sum;
}

void WeightedEdgeBatch::WeighLosses(int first, const double* s, int count, double* weight, double* rank_one) const {
  if (common_loss_) return common_loss_->Weigh(s, count, weight, rank_one);
  for (int k = 0; k < count; ++k) {
    const RobustWeight robust = WeightAt(unweighted_ ? nullptr : losses_[first + k], s[k]);
    weight[k] = robust.weight;
    rank_one[k] = robust.rank_one;
  }
}

}  // namespace ch5
