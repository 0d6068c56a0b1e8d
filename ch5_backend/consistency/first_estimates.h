#pragma once
/// First-estimate Jacobians: a state in the prior is linearised, once and for all, where the prior was linearised.
///
/// The prior's J has its null space at x₀. Edges that are linearised elsewhere have theirs elsewhere, and the null space
/// of both together shrinks: yaw seems to become observable. The estimators use the milder remedy of observability.h;
/// this one is the original and the reference in the tests.
/// Source: Huang, Mourikis, Roumeliotis, "Observability-based rules for designing consistent EKF SLAM estimators",
/// IJRR 2010; Leutenegger et al., IJRR 2015, §4.3.

#include <utility>
#include <vector>

#include "ch5_backend/consistency/modified_jacobians.h"
#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

/// An edge with the residual at the present states, but with the Jacobians at the prior's linearisation points, for
/// those of its vertices that the prior holds. Evaluation moves the vertices temporarily: one thread only.
class EdgeFirstEstimate : public EdgeWithModifiedJacobians {
 public:
  /// @param edge   must not be in any graph;  @param prior  must outlive this edge
  EdgeFirstEstimate(std::shared_ptr<Edge> edge, const Prior* prior);
  void ComputeJacobians() override;

 private:
  std::vector<std::pair<Vertex*, const VecX*>> points_;
};

}  // namespace ch5
