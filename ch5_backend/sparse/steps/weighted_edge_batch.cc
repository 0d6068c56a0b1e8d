#include "ch5_backend/sparse/steps/weighted_edge_batch.h"

#include <algorithm>
#include <typeinfo>

namespace ch5 {

bool WeightedEdgeBatch::Start(const Edge& first, bool relative) {
  if (!type_ || *type_ != typeid(first)) batch_ = AsFast(first) ? AsFast(first)->MakeBatch() : nullptr;
  type_ = &typeid(first);
  if (!batch_ || batch_->IsRelative() != relative) return false;
  jacobian_begin_.assign(1, 0);
  block_begin_.assign(1, 0);
  const auto append = [this](int dim) {
    jacobian_begin_.push_back(jacobian_begin_.back() + kRows * dim);
    block_begin_.push_back(block_begin_.back() + kRows * Stride(dim));
  };
  const size_t own = relative ? 1 : first.Vertices().size();  // the others are seen through ξ
  for (size_t v = 0; v < own; ++v) append(first.Vertices()[v]->LocalDimension());
  if (relative) append(RelativeJacobian::kDim);
  batch_->Clear();
  information_.clear();
  losses_.clear();
  size_ = 0;
  unweighted_ = true;
  common_loss_ = first.GetLossFunction();
  return first.ResidualDimension() == kRows && first.Vertices().size() <= kMostVertices &&
         NumJacobians() <= kRows * kMostColumns;
}

bool WeightedEdgeBatch::Add(const Edge& edge) {
  const double information = edge.IsotropicInformation();
  const LossFunction* loss = edge.GetLossFunction();
  if (information < 0.0) return false;
  batch_->Add(edge);
  if (loss != common_loss_) common_loss_ = nullptr;
  if (unweighted_ && (information != 1.0 || loss)) {
    unweighted_ = false;
    information_.reserve(capacity_);
    losses_.reserve(capacity_);
    information_.assign(static_cast<size_t>(size_), 1.0);
    losses_.assign(static_cast<size_t>(size_), nullptr);
  }
  ++size_;
  if (unweighted_) return true;
  information_.push_back(information);
  losses_.push_back(loss);
  return true;
}

void LandmarkEdgeBatches::Assign(const Structure& s) {
  active_ = s.sizes.AreFixed() && s.num_landmark_edges > 0 && s.num_edge_types <= kMostTypes && AddAll(s);
}

bool LandmarkEdgeBatches::AddAll(const Structure& s) {
  constexpr int kPrefetchDistance = 12, kLines = 6;  // whole edges, with what their batch copies
  batches_.resize(static_cast<size_t>(s.num_edge_types));
  places_.clear();
  const bool is_one_type = s.num_edge_types == 1;
  bool started[kMostTypes] = {};
  for (int e = 0; e < s.num_landmark_edges; ++e) {
    if (e + kPrefetchDistance < s.num_landmark_edges)
      PrefetchObject(s.edges[s.BatchEdge(e + kPrefetchDistance)].edge, kLines);
    const EdgeRecord& record = s.edges[s.BatchEdge(e)];
    WeightedEdgeBatch& batch = batches_[record.type];
    if (!started[record.type]) {
      if (!batch.Start(*record.edge, s.BatchGoesByRuns())) return false;
      if (is_one_type) batch.Reserve(static_cast<size_t>(s.num_landmark_edges));
      started[record.type] = true;
    }
    if (!is_one_type) places_.push_back({record.type, batch.Size()});
    if (!batch.Add(*record.edge)) return false;
  }
  return true;
}

void LandmarkEdgeBatches::LoadPoses() {
  for (int type = 0; type < NumTypes(); ++type) batches_[type].LoadPoses();
}

// A type's edges in a range are a range of its batch.
double LandmarkEdgeBatches::Cost(int begin, int end) const {
  if (places_.empty()) return batches_.front().Cost(begin, end);
  int first[kMostTypes], count[kMostTypes] = {};
  for (int e = begin; e < end; ++e) {
    const Place& place = places_[e];
    if (count[place.type]++ == 0) first[place.type] = place.number;
  }
  double sum = 0.0;
  for (size_t type = 0; type < batches_.size(); ++type) {
    if (count[type] > 0) sum += batches_[type].Cost(first[type], first[type] + count[type]);
  }
  return sum;
}

double WeightedEdgeBatch::Cost(int begin, int end) const {
  constexpr int kAtOnce = 8 * kPack;
  alignas(64) double r[kRows * kPack], s[kAtOnce];
  double sum = 0.0;
  for (int start = begin; start < end; start += kAtOnce) {
    const int num = std::min(kAtOnce, end - start);
    for (int k = 0; k < num; k += kPack) {
      const int count = std::min(kPack, num - k);
      ComputeResiduals(start + k, count, r);
      Square(start + k, count, r, s + k);
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
  if (common_loss_) return common_loss_->Weigh(s, kPack, weight, rank_one);
  for (int k = 0; k < count; ++k) {
    const RobustWeight robust = WeightAt(unweighted_ ? nullptr : losses_[first + k], s[k]);
    weight[k] = robust.weight;
    rank_one[k] = robust.rank_one;
  }
}

}  // namespace ch5
