#pragma once
/// Residuals for stage 6 whose numbers are random, so that A has no structure to hide a mistake in; and the right A and
/// b, built in another way than the homework does.

#include <algorithm>
#include <string>
#include <vector>

#include "ch5_backend/graph/loss.h"
#include "tests/homework/narrate.h"
#include "tests/homework/scenes.h"
#include "tests/homework/submission.h"

namespace ch5::homework {

/// "VertexPose 3"
inline std::string NameOf(const Vertex& vertex) { return vertex.TypeInfo() + " " + std::to_string(vertex.Id()); }

/// An edge whose numbers are those of an older state until it is linearised.
class AgedEdge {
 public:
  virtual ~AgedEdge() = default;
  virtual bool IsFresh() const = 0;
};
template <int R, typename... V>
class AgedRandomEdge : public RandomEdge<R, V...>, public AgedEdge {
 public:
  AgedRandomEdge(Random* random, std::shared_ptr<V>... vertices) : RandomEdge<R, V...>(random, std::move(vertices)...) {
    right_r_ = this->r_;
    this->r_ = RandomMatrix(R, 1, random);
    for (size_t i = 0; i < sizeof...(V); ++i) {
      right_J_.push_back(this->Jacobian(i));
      old_J_.push_back(RandomMatrix(R, this->vertices_[i]->LocalDimension(), random));
      SetJ(i, old_J_[i]);
    }
  }
  void ComputeResidual() override { this->r_ = right_r_; }
  void ComputeJacobians() override {
    for (size_t i = 0; i < sizeof...(V); ++i) SetJ(i, right_J_[i]);
  }
  bool IsFresh() const override {
    for (size_t i = 0; i < sizeof...(V); ++i) {
      if (this->Jacobian(i) != right_J_[i]) return false;
    }
    return this->r_ == right_r_;
  }

 private:
  void SetJ(size_t i, const MatXX& J) {
    Eigen::Map<MatXX>(this->jacobians_[i], R, this->vertices_[i]->LocalDimension()) = J;
  }
  Eigen::Matrix<double, R, 1> right_r_;
  std::vector<MatXX> right_J_, old_J_;
};

/// Three poses, a speed-bias, three depths and a fixed extrinsic; dropped are the middle pose, the speed-bias and the
/// last depth, so that dropped and kept ids alternate and no id is a position.
class FactorScene {
 public:
  enum Kind { kRobust, kNoLoss, kOneEdge };

  std::vector<std::shared_ptr<Vertex>> free;  ///< in order of id
  std::shared_ptr<Vertex> fixed;
  std::vector<ResidualBlockInfo> factors;

  explicit FactorScene(Kind kind = kRobust) {
    Random random(Seed(67));
    Graph* graph = &graph_;
    const auto poses = AddPoses(graph, 4);
    const auto speed_bias = AddVertices<VertexSpeedBias>(graph, 1, [] { return std::make_shared<VertexSpeedBias>(); });
    const auto depths = AddInverseDepths(graph, 3);
    for (size_t k = 0; k < poses.size(); ++k) poses[k]->Plus(RandomMatrix(6, 1, &random).data());
    fixed = poses[3];
    fixed->SetFixed();
    const auto& p = poses;
    const auto& d = depths;
    Add<6>(&random, {1}, nullptr, p[0], p[1]);
    if (kind == kOneEdge) return;
    const auto cauchy = kind == kRobust ? std::make_shared<CauchyLoss>(1.0) : nullptr;
    Add<9>(&random, {1, 2}, nullptr, p[2], speed_bias[0], p[1]);
    Add<2>(&random, {1}, cauchy, d[0], p[1], p[2], p[3]);
    Add<2>(&random, {2, 0}, cauchy, d[2], p[0], p[1]);
    Add<2>(&random, {1}, cauchy, p[2], d[2]);  // its other vertices are kept
    Add<3>(&random, {}, nullptr, p[0], d[1]);  // drops nothing
    Add<3>(&random, {1}, nullptr, d[1], p[1]);
    std::sort(free.begin(), free.end(), [](const auto& a, const auto& b) { return a->Id() < b->Id(); });
  }

  std::unique_ptr<VinsTerm> Fill() const {
    auto term = Chosen().make_vins_term();
    for (const auto& factor : factors) term->AddResidualBlockInfo(factor);
    return term;
  }
  bool IsFresh(const Edge& edge) const { return dynamic_cast<const AgedEdge&>(edge).IsFresh(); }

  std::vector<std::shared_ptr<Vertex>> Dropped() const { return Select(true); }
  std::vector<std::shared_ptr<Vertex>> Kept() const { return Select(false); }
  int DimDropped() const { return SizeOf(Dropped()); }

  /// How A and b may be put together wrongly.
  struct Way {
    bool robust_A = true, second_order = true, drho_in_A_again = false;
    bool drho_in_b = true, drho_in_b_again = false, robust_b = false;
    bool last_only = false, mirror = true, transpose = true, doubled = false;
  };
  MatXX MatrixA(const Way& way) const {
    const int size = SizeOf(free);
    MatXX A = MatXX::Zero(size, size);
    for (const auto& factor : factors) {
      const Edge& edge = *factor.edge;
      double drho;
      MatXX W;
      RightRobustInfo(factor.edge.get(), &drho, &W);
      if (!way.second_order) W = drho * edge.Information();
      if (!way.robust_A) W = edge.Information();
      if (way.drho_in_A_again) W *= drho;
      for (size_t i = 0; i < edge.Vertices().size(); ++i) {
        for (size_t j = i; j < edge.Vertices().size(); ++j) AddPair(edge, i, j, W, way, &A);
      }
    }
    return A;
  }
  VecX VectorB(const Way& way) const {
    VecX b = VecX::Zero(SizeOf(free));
    for (const auto& factor : factors) {
      const Edge& edge = *factor.edge;
      double drho;
      MatXX W;
      RightRobustInfo(factor.edge.get(), &drho, &W);
      for (size_t i = 0; i < edge.Vertices().size(); ++i) {
        const Vertex& v = *edge.Vertices()[i];
        if (v.IsFixed()) continue;
        VecX share = edge.Jacobian(i).transpose() * edge.Information() * edge.Residual();
        if (way.robust_b) share = edge.Jacobian(i).transpose() * W * edge.Residual();
        if (way.drho_in_b && !way.robust_b) share *= drho;
        if (way.drho_in_b_again) share *= drho;
        auto rows = b.segment(RowOf(v), v.LocalDimension());
        rows = way.last_only ? share : VecX(rows + share);
      }
    }
    return b;
  }

  std::vector<Mistake> MistakesInA() const {
    const auto is = [this](const Way& way) { return std::function<MatXX()>([=] { return MatrixA(way); }); };
    Way no_loss, first_order, twice, last, one_side, untransposed, doubled;
    no_loss.robust_A = first_order.second_order = false;
    twice.drho_in_A_again = last.last_only = doubled.doubled = true;
    one_side.mirror = untransposed.transpose = false;
    const int size = SizeOf(free);
    return {{"6c", "nothing is written to A_", [=] { return MatXX::Zero(size, size); }},
            {"6c", "the loss is forgotten: W_rho, not edge.Information()", is(no_loss)},
            {"6c", "ρ'W stands where W_ρ is meant: W_rho holds the second derivative too", is(first_order)},
            {"6c", "the loss acts twice: W_rho has ρ' in it already", is(twice)},
            {"6c", "= stands where += is meant: only the last residual's share is left", is(last)},
            {"6c", "the mirrored block is missing", is(one_side)},
            {"6c", "the mirrored block is not transposed", is(untransposed)},
            {"6c", "the diagonal blocks are doubled: the mirror is for j ≠ i only", is(doubled)},
            {"6c", "the sign: A = +Σ JᵀW_ρJ", [this] { return MatXX(-MatrixA({})); }}};
  }
  std::vector<Mistake> MistakesInB() const {
    const auto is = [this](const Way& way) { return std::function<MatXX()>([=] { return VectorB(way); }); };
    Way no_loss, twice, robust, last;
    no_loss.drho_in_b = false;
    twice.drho_in_b_again = robust.robust_b = last.last_only = true;
    return {{"6c", "the sign: VINS' b is +Σ ρ'JᵀWr, that of A Δx = −b", [this] { return VecX(-VectorB({})); }},
            {"6c", "nothing is written to b_", [this] { return VecX::Zero(SizeOf(free)); }},
            {"6c", "the loss is forgotten: ρ' is missing", is(no_loss)},
            {"6c", "the loss acts twice", is(twice)},
            {"6c", "W_ρ is for A; b takes ρ'W", is(robust)},
            {"6c", "= stands where += is meant: only the last residual's share is left", is(last)}};
  }

  /// What each row of A belongs to: the dropped blocks first.
  Names RowNames() const {
    Ordering rows;  // only for the names
    rows.poses = Dropped();
    rows.landmarks = Kept();
    return homework::RowNames(rows);
  }

 private:
  template <int R, typename... V>
  void Add(Random* random, std::vector<int> drop_set, std::shared_ptr<const LossFunction> loss,
           std::shared_ptr<V>... vertices) {
    auto edge = std::make_shared<AgedRandomEdge<R, V...>>(random, vertices...);
    edge->SetLossFunction(std::move(loss));
    for (const auto& vertex : edge->Vertices()) {
      if (!vertex->IsFixed() && std::find(free.begin(), free.end(), vertex) == free.end()) free.push_back(vertex);
    }
    for (const int position : drop_set) dropped_.push_back(edge->Vertices()[static_cast<size_t>(position)]);
    factors.push_back({std::move(edge), std::move(drop_set)});
  }
  std::vector<std::shared_ptr<Vertex>> Select(bool dropped) const {
    std::vector<std::shared_ptr<Vertex>> selected;
    for (const auto& vertex : free) {
      if ((std::find(dropped_.begin(), dropped_.end(), vertex) != dropped_.end()) == dropped)
        selected.push_back(vertex);
    }
    return selected;
  }
  static int SizeOf(const std::vector<std::shared_ptr<Vertex>>& vertices) {
    int size = 0;
    for (const auto& vertex : vertices) size += vertex->LocalDimension();
    return size;
  }
  int RowOf(const Vertex& vertex) const {
    int row = 0;
    for (const auto& vertices : {Dropped(), Kept()}) {
      for (const auto& other : vertices) {
        if (other.get() == &vertex) return row;
        row += other->LocalDimension();
      }
    }
    return -1;
  }
  static void RightRobustInfo(Edge* edge, double* drho, MatXX* W) {
    edge->Linearize();
    edge->RobustInfo(drho, W);
  }
  void AddPair(const Edge& edge, size_t i, size_t j, const MatXX& W, const Way& way, MatXX* A) const {
    const Vertex &v = *edge.Vertices()[i], &w = *edge.Vertices()[j];
    if (v.IsFixed() || w.IsFixed()) return;
    const MatXX share = edge.Jacobian(i).transpose() * W * edge.Jacobian(j);
    auto block = A->block(RowOf(v), RowOf(w), v.LocalDimension(), w.LocalDimension());
    block = way.last_only ? share : MatXX(block + share);
    if (i == j && way.doubled) block += share.transpose();
    if (i == j || !way.mirror) return;
    auto mirror = A->block(RowOf(w), RowOf(v), w.LocalDimension(), v.LocalDimension());
    const MatXX mirrored = way.transpose || share.rows() != share.cols() ? MatXX(share.transpose()) : share;
    mirror = way.last_only ? mirrored : MatXX(mirror + mirrored);
  }

  Graph graph_;
  std::vector<std::shared_ptr<Vertex>> dropped_;
};

}  // namespace ch5::homework
