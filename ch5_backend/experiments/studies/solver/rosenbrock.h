#pragma once
/// Rosenbrock's valley as least squares:  r = [10 (y − x²), 1 − x],  minimum 0 at (1, 1).

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

class EdgeRosenbrock : public SizedEdge<2, VertexVector<2>> {
 public:
  explicit EdgeRosenbrock(std::shared_ptr<VertexVector<2>> xy) : SizedEdge(std::move(xy)) {}
  void ComputeResidual() override {
    const Vec2& p = GetVertex<0>().GetEstimate();
    r_ << 10.0 * (p.y() - p.x() * p.x()), 1.0 - p.x();
  }
  void ComputeJacobians() override { J<0>() << -20.0 * GetVertex<0>().GetEstimate().x(), 10.0, -1.0, 0.0; }
  std::string TypeInfo() const override { return "EdgeRosenbrock"; }
};

/// The problem at its usual start, (−1.2, 1).
/// @return its vertex
inline std::shared_ptr<VertexVector<2>> BuildRosenbrock(Graph* graph) {
  auto xy = std::make_shared<VertexVector<2>>(Vec2(-1.2, 1.0));
  graph->AddVertex(xy);
  graph->AddEdge(std::make_shared<EdgeRosenbrock>(xy));
  return xy;
}

}  // namespace ch5
