#pragma once
/// First-estimate Jacobians: a state that a prior knows is linearised, once and for all, where the prior was.
///
/// A prior's J has its null space at x₀. Edges that are linearised elsewhere have theirs elsewhere, and what is common
/// to both shrinks: yaw seems to become known. Source: Huang, Mourikis, Roumeliotis, "Observability-based rules for
/// designing consistent EKF SLAM estimators", IJRR 2010; Leutenegger et al., IJRR 2015, §4.3.

#include "ch5_backend/marginalize/moved_vertices.h"

namespace ch5 {

enum class FirstEstimates {
  kNone,       ///< all edges at the present states; a prior keeps its J all the same (VINS-Mono)
  kPriorOnly,  ///< what enters a prior is linearised at the x₀ of the states that the old prior knows (OKVIS)
  kFull        ///< so are the edges of the solve
};

/// Another edge's residual, information and loss with Jacobians of one's own.
class EdgeOtherJacobians : public Edge {
 public:
  void ComputeResidual() override;
  std::string TypeInfo() const override { return edge_->TypeInfo(); }

 protected:
  /// @param edge   not in any graph
  explicit EdgeOtherJacobians(std::shared_ptr<Edge> edge);
  /// J := the other edge's Jacobians at the present states.
  void CopyJacobians();

  MatXX J_;  // the vertices' blocks side by side

 private:
  std::shared_ptr<Edge> edge_;
  VecX r_;
  MatXX W_;
};

/// An edge whose residual is that of the present states, but whose Jacobians are those at the linearisation points of a
/// prior, for the vertices that the prior knows. The vertices move for a moment: one thread only.
class EdgeFirstEstimate : public EdgeOtherJacobians {
 public:
  /// @param edge   not in any graph;  @param prior  must outlive this edge
  EdgeFirstEstimate(std::shared_ptr<Edge> edge, const Prior* prior);
  void ComputeJacobians() override;

 private:
  std::vector<std::pair<Vertex*, const VecX*>> points_;
};

}  // namespace ch5
