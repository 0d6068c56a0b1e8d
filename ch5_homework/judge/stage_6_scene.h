#pragma once
/// The right A and b of stage 6's residuals, built in another way than the homework does.

#include <algorithm>
#include <string>
#include <vector>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/scenes/factors.h"

namespace ch5::homework {

class FactorScene : public FactorGraph {
 public:
  using FactorGraph::FactorGraph;

  /// The vertex at this place of the scene.  @throws WireError if there is none
  std::shared_ptr<Vertex> At(double place) {
    const VertexList vertices = Vertices();
    if (!(place >= 0.0 && place < static_cast<double>(vertices.size())))
      throw WireError("a place outside of the scene");
    return vertices[static_cast<size_t>(place)];
  }
  int PlaceOf(const std::shared_ptr<Vertex>& vertex) {
    const VertexList vertices = Vertices();
    return static_cast<int>(std::find(vertices.begin(), vertices.end(), vertex) - vertices.begin());
  }

  std::vector<std::shared_ptr<Vertex>> Dropped() const { return Select(true); }
  std::vector<std::shared_ptr<Vertex>> Kept() const { return Select(false); }
  int DimDropped() const { return RowsOf(Dropped()); }

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
        StackedNormalEquations(Edges(), RowsOf(free), [this](const Vertex& vertex) { return RowOf(vertex); });
    return {system.H, -system.b};
  }

  /// What each row of A belongs to: the dropped blocks first.
  Names RowNames() const { return homework::RowNames(Dropped()) + homework::RowNames(Kept()); }

 private:
  std::vector<std::shared_ptr<Vertex>> Select(bool dropped) const {
    std::vector<std::shared_ptr<Vertex>> selected;
    for (const auto& vertex : free) {
      if ((std::find(dropped_.begin(), dropped_.end(), vertex) != dropped_.end()) == dropped)
        selected.push_back(vertex);
    }
    return selected;
  }
};

}  // namespace ch5::homework
