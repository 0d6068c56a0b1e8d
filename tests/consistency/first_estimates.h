#pragma once
/// First-estimate Jacobians, the original remedy: a state in the prior is linearized, once and for all, where the prior was
/// linearized. The reference for the observability constraints, which the estimators use.
/// Source: Huang, Mourikis, Roumeliotis, "Observability-based rules for designing consistent EKF SLAM estimators",
/// IJRR 2010; Leutenegger et al., IJRR 2015, §4.3.

#include <algorithm>
#include <utility>
#include <vector>

#include "ch5_backend/consistency/modified_jacobians.h"
#include "ch5_backend/marginalize/scoped_linearization_point.h"

namespace ch5 {

/// An edge with the residual at the present states, but with the Jacobians at the prior's linearization points, for
/// those of its vertices that the prior holds. Evaluation moves the vertices temporarily: one thread only.
class EdgeFirstEstimate : public EdgeWithModifiedJacobians {
 public:
  /// @param edge   must not be in any graph;  @param prior  must outlive this edge
  EdgeFirstEstimate(std::shared_ptr<Edge> edge, const Prior* prior) : EdgeWithModifiedJacobians(std::move(edge)) {
    for (const auto& vertex : Vertices()) {
      const auto known = std::find(prior->vertices.begin(), prior->vertices.end(), vertex);
      if (known == prior->vertices.end()) continue;
      points_.emplace_back(vertex.get(), &prior->x0[static_cast<size_t>(known - prior->vertices.begin())]);
    }
  }
  void ComputeJacobians() override {
    ScopedLinearizationPoint at_first_estimates;
    for (const auto& [vertex, x0] : points_) at_first_estimates.Move(vertex, *x0);
    CopyJacobians();
  }

 private:
  std::vector<std::pair<Vertex*, const VecX*>> points_;
};

}  // namespace ch5
