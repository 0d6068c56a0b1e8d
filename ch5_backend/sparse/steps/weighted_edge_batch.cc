#include "ch5_backend/sparse/steps/weighted_edge_batch.h"

#include <algorithm>
#include <typeinfo>

namespace ch5 {
namespace {

// Edges of a type without batches, each linearized by itself.
class SingleEdges : public EdgeBatch {
 public:
  void Clear() override { edges_.clear(); }
  void Reserve(size_t count) override { edges_.reserve(count); }
  void Add(const Edge& edge) override { edges_.push_back(const_cast<Edge*>(&edge)); }  // which holds its own r and J
  void LoadPoses() override {}
  void ComputeResiduals(int first, int count, double* r) const override {
    for (int k = 0; k < count; ++k) {
      edges_[first + k]->ComputeResidual();
      CopyResidual(first + k, r + k);
    }
    FillLanes(count, WeightedEdgeBatch::kRows, r);
  }
  void Linearize(int first, int count, double* r, double* J) const override {
    constexpr int kPrefetchDistance = 6, kLines = 6;
    int numbers = 0;
    for (int k = 0; k < count; ++k) {
      if (first + k + kPrefetchDistance < static_cast<int>(edges_.size()))
        PrefetchObject(edges_[first + k + kPrefetchDistance], kLines);
      Edge& edge = *edges_[first + k];
      edge.Linearize();
      CopyResidual(first + k, r + k);
      numbers = 0;
      for (size_t v = 0; v < edge.Vertices().size(); ++v) {
        const auto J_v = edge.Jacobian(v);
        for (Eigen::Index i = 0; i < J_v.size(); ++i) J[kPack * numbers++ + k] = J_v.data()[i];
      }
    }
    FillLanes(count, numbers, J);
    FillLanes(count, WeightedEdgeBatch::kRows, r);
  }

 private:
  void CopyResidual(int e, double* r) const {
    const auto residual = edges_[e]->Residual();
    for (int i = 0; i < WeightedEdgeBatch::kRows; ++i) r[i * kPack] = residual[i];
  }
  // Copies of the last edge's numbers into the lanes without an edge.
  static void FillLanes(int count, int numbers, double* x) {
    for (int i = 0; i < numbers && count < kPack; ++i, x += kPack) std::fill(x + count, x + kPack, x[count - 1]);
  }

  Array<Edge*> edges_;
};

std::unique_ptr<EdgeBatch> MakeBatch(Edge* edge) {
  std::unique_ptr<EdgeBatch> own = AsFast(*edge) ? AsFast(*edge)->MakeBatch() : nullptr;
  return own ? std::move(own) : std::make_unique<SingleEdges>();
}

}  // namespace

bool WeightedEdgeBatch::Start(Edge* first_edge, bool relative) {
  Edge& first = *first_edge;
  if (!type_ || *type_ != typeid(first)) batch_ = MakeBatch(&first);
  type_ = &typeid(first);
  if (batch_->IsRelative() != relative) return false;
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
  if (first.ResidualDimension() != kRows || first.Vertices().size() > kMostVertices ||
      NumJacobians() > kRows * kMostColumns)
    return false;
  goes_one_by_one_ = dynamic_cast<const SingleEdges*>(batch_.get()) != nullptr;
  if (goes_one_by_one_) first.Linearize();
  return !goes_one_by_one_ || !first.HasNumericJacobians();
}

// Edges of one type may yet differ, if their sizes are known at run time only.
bool WeightedEdgeBatch::HasSizesOf(const Edge& edge) const {
  const VertexSpan& vertices = edge.Vertices();
  bool same = edge.ResidualDimension() == kRows && static_cast<int>(vertices.size()) == NumPositions();
  for (int v = 0; v < NumPositions() && same; ++v) same = vertices[v]->LocalDimension() == Dimension(v);
  return same;
}

bool WeightedEdgeBatch::Add(const Edge& edge) {
  const double information = edge.IsotropicInformation();
  const LossFunction* loss = edge.GetLossFunction();
  if (information < 0.0 || (goes_one_by_one_ && !HasSizesOf(edge))) return false;
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
      if (!batch.Start(record.edge, s.BatchGoesByRuns())) return false;
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
