#pragma once
/// A window of edges of one's own in which nothing is learned twice: vertices of a prior are linearized where the prior was.
///
///   FirstEstimates first;
///   graph.AddEdge(first.Hold(edge));           // each edge, instead of edge
///   optimizer.Solve(options);                  // by Algorithm::kGaussNewton
///   first.MarginalizeInto(&graph, drop);       // instead of ch5::MarginalizeInto
///
/// A prior keeps the Jacobian of the states at which it was made. An edge that is linearized elsewhere later contradicts it: the
/// two together know directions that nothing has measured, of yaw above all, and drift apart from the batch. So a held edge's
/// residual is that of the present states, its Jacobians are those at the states at which its vertices first entered a prior.
/// They are then no derivative of the cost, which rises in places where the step is right: a strategy that rejects such steps
/// stops early. Solve with one thread: to linearize, a held edge moves its vertices for a moment.  Huang, Mourikis, Roumeliotis, "A First-Estimates Jacobian EKF", ISER 2008. Position and yaw alone can be
/// held instead: consistency/observability.h.

#include <memory>
#include <unordered_map>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

class FirstEstimates {
 public:
  /// The edge, linearized so. It takes over residual, information and loss, and must not be in a graph itself.
  std::shared_ptr<Edge> Hold(std::shared_ptr<Edge> edge) const;
  /// ch5::MarginalizeInto, after which the prior keeps its Jacobian and its vertices their states of now, unless they have been
  /// in a prior before. Vertices leave the graph by this function alone.
  std::shared_ptr<EdgePrior> MarginalizeInto(Graph* graph, const std::vector<std::shared_ptr<Vertex>>& drop);

 private:
  using States = std::unordered_map<const Vertex*, VecX>;
  std::shared_ptr<States> states_ = std::make_shared<States>();  // shared with the edges
};

}  // namespace ch5
