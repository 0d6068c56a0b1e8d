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

  /// The dropped rows first.
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
  /// A and b, with VINS' sign, at the present states.
  System Right() {
    for (const auto& factor : factors) factor.edge->Linearize();
    const System system =
        StackedNormalEquations(Edges(), SizeOf(free), [this](const Vertex& vertex) { return RowOf(vertex); });
    return {system.H, -system.b};
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
};

}  // namespace ch5::homework
