/// ReplacePrior. Apart from window.cc, so that a window can be had without what marginalizes it.

#include <algorithm>

#include "ch5_backend/marginalize/drop_ordering.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/window/window.h"

namespace ch5 {
namespace {

// The edges with observability constraints, where the graph's are not constrained already.
std::vector<std::shared_ptr<Edge>> Constrained(std::vector<std::shared_ptr<Edge>> edges, const Window& window) {
  if (window.observability_constraints == ObservabilityConstraints::kAllEdges) return edges;
  const std::vector<const Vertex*> local_poses = window.LocalPoses();
  for (auto& edge : edges) {
    if (edge == window.prior) continue;
    edge = ConstrainObservability(edge, window.prior->GetPrior(), local_poses);
  }
  return edges;
}

// The next prior's vertices keep the first estimates of the old one.
void KeepFirstEstimates(const Prior& old, Prior* next) {
  next->first_estimates = next->x0;
  for (size_t i = 0; i < next->vertices.size(); ++i) {
    const auto at = std::find(old.vertices.begin(), old.vertices.end(), next->vertices[i]);
    if (at != old.vertices.end()) next->first_estimates[i] = old.FirstEstimate(at - old.vertices.begin());
  }
}

}  // namespace

void ReplacePrior(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  Window* window) {
  // Some have no edge in the last solve's graph, such as a landmark that was not used.
  const std::vector<std::shared_ptr<Vertex>> dropped = FixedOrAtEdges(drop, edges);
  const std::shared_ptr<EdgePrior> old = window->prior;
  if (window->observability_constraints == ObservabilityConstraints::kNone || !old) {
    window->prior = window->marginalizer ? window->marginalizer(edges, dropped)
                                         : MakeShared<EdgePrior>(Marginalize(edges, dropped));
    return;
  }
  old->KeepJacobian(true);
  Prior next = Marginalize(Constrained(edges, *window), dropped);
  KeepFirstEstimates(old->GetPrior(), &next);
  window->prior = MakeShared<EdgePrior>(std::move(next));
}

}  // namespace ch5
