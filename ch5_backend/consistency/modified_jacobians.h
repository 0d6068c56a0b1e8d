#pragma once
/// An edge that takes over another edge's residual, information and loss, but has Jacobians of its own: the base of
/// the observability constraints (observability.h), and of first-estimate Jacobians.

#include "ch5_backend/graph/edge.h"

namespace ch5 {

class EdgeWithModifiedJacobians : public Edge {
 public:
  void ComputeResidual() override;
  std::string TypeInfo() const override { return edge_->TypeInfo(); }

 protected:
  /// @param edge  must not be in any graph
  explicit EdgeWithModifiedJacobians(std::shared_ptr<Edge> edge);
  /// J := the other edge's Jacobians at the present states.
  void CopyJacobians();

  MatXX J_;  // the vertices' blocks side by side

 private:
  std::shared_ptr<Edge> edge_;
  VecX r_;
  MatXX W_;
};

}  // namespace ch5
