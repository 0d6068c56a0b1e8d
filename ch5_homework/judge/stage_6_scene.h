#pragma once
/// The right A and b of stage 6's residuals, built in another way than the homework does.

#include <algorithm>
#include <string>
#include <vector>

#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/scenes/factors.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

/// "VertexPose 3"
inline std::string NameOf(const Vertex& vertex) { return vertex.TypeInfo() + " " + std::to_string(vertex.Id()); }

class FactorScene : public FactorGraph {
 public:
  using FactorGraph::FactorGraph;

  std::unique_ptr<MarginalizationInfo> Fill() const {
    auto term = Chosen().make_marginalization_info();
    for (const auto& factor : factors) term->AddResidualBlockInfo(factor);
    return term;
  }
  bool IsFresh(const Edge& edge) const { return dynamic_cast<const AgedEdge&>(edge).IsFresh(); }

  std::vector<std::shared_ptr<Vertex>> Dropped() const { return Select(true); }
  std::vector<std::shared_ptr<Vertex>> Kept() const { return Select(false); }
  int DimDropped() const { return SizeOf(Dropped()); }

  /// How A and b may be put together, wrongly or (by default) rightly.
  struct Way {
    double diagonal = 1.0, first = 1.0, mirror = 1.0;  ///< how often a block (i, i), (i, j) and its mirror are added
    bool last_only = false;                            ///< = for +=
    bool transpose = true;                             ///< of the mirror
    bool exchanged = false;                            ///< (i, j) at (j, i), its mirror at (i, j)
    bool stops_at_fixed = false;                       ///< no pair behind a fixed vertex
    bool idx_of_i = false, J_of_i = false;             ///< for that of j
    double with_each_j = 0.0;                          ///< b's share once more for each j ≥ i
    double with_each_i = 0.0;                          ///< of vertex j, once more for each i < j
    MatXX (*weight_A)(const Edge& edge, double drho, const MatXX& W_rho) = nullptr;
    MatXX (*weight_b)(const Edge& edge, double drho, const MatXX& W_rho) = nullptr;
  };
  MatXX MatrixA(const Way& way) const {
    MatXX A = MatXX::Zero(SizeOf(free), SizeOf(free));
    ForEach([&](const Edge& edge, double drho, const MatXX& W_rho) {
      const MatXX W = way.weight_A ? way.weight_A(edge, drho, W_rho) : W_rho;
      for (size_t i = 0; i < edge.Vertices().size(); ++i) {
        for (size_t j = i; j < edge.Vertices().size(); ++j) {
          if (way.stops_at_fixed && edge.Vertices()[j]->IsFixed()) break;
          AddPair(edge, i, j, W, way, &A);
        }
      }
    });
    return A;
  }
  VecX VectorB(const Way& way) const {
    VecX b = VecX::Zero(SizeOf(free));
    ForEach([&](const Edge& edge, double drho, const MatXX& W_rho) {
      const MatXX W = way.weight_b ? way.weight_b(edge, drho, W_rho) : MatXX(drho * edge.Information());
      const auto& vertices = edge.Vertices();
      const auto is_free = [](const auto& v) { return !v->IsFixed(); };
      auto before = static_cast<double>(std::count_if(vertices.begin(), vertices.end(), is_free)), behind = 0.0;
      for (size_t i = vertices.size(); i-- > 0;) {
        const Vertex& v = *vertices[i];
        if (v.IsFixed()) continue;
        const double times = 1.0 + way.with_each_j * ++behind + way.with_each_i * --before;
        auto rows = b.segment(RowOf(v), v.LocalDimension());
        const VecX share = times * edge.Jacobian(i).transpose() * W * edge.Residual();
        rows = way.last_only ? share : VecX(rows + share);
      }
    });
    return b;
  }

  /// What each row of A belongs to: the dropped blocks first.
  Names RowNames() const {
    Ordering rows;  // only for the names
    rows.poses = Dropped();
    rows.landmarks = Kept();
    return homework::RowNames(rows);
  }

 private:
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
  template <typename Do>
  void ForEach(const Do& with) const {
    for (const auto& factor : factors) {
      double drho;
      MatXX W_rho;
      factor.edge->Linearize();
      factor.edge->RobustInfo(&drho, &W_rho);
      with(*factor.edge, drho, W_rho);
    }
  }
  void AddPair(const Edge& edge, size_t i, size_t j, const MatXX& W, const Way& way, MatXX* A) const {
    const Vertex *v = edge.Vertices()[i].get(), *w = edge.Vertices()[j].get();
    if (v->IsFixed() || w->IsFixed()) return;
    const bool alike = v->LocalDimension() == w->LocalDimension();
    const MatXX share = edge.Jacobian(i).transpose() * W * edge.Jacobian(way.J_of_i && alike ? i : j);
    if (way.exchanged && alike) std::swap(v, w);
    if (way.idx_of_i && alike) w = v;
    auto block = A->block(RowOf(*v), RowOf(*w), v->LocalDimension(), w->LocalDimension());
    const MatXX first = (i == j ? way.diagonal : way.first) * share;
    block = way.last_only ? first : MatXX(block + first);
    if (i == j) return;
    auto mirror = A->block(RowOf(*w), RowOf(*v), w->LocalDimension(), v->LocalDimension());
    const MatXX mirrored = way.mirror * (way.transpose || !alike ? MatXX(share.transpose()) : share);
    mirror = way.last_only ? mirrored : MatXX(mirror + mirrored);
  }
};

}  // namespace ch5::homework
