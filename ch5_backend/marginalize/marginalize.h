#pragma once
/// Marginalization as a function:  edges + vertices to drop → a prior on the rest.
///
///         kept   dropped  dropped landmarks l
///       ┌──────┬──────┬──────┐
///       │ H_kk │ H_kd │      │
///   H = ├──────┼──────┤ H_pl │     p = kept and dropped together: the dense part
///       │ H_dk │ H_dd │      │     H_ll = one small block per landmark, on the diagonal
///       ├──────┴──────┼──────┤
///       │    H_lp     │ H_ll │
///       └─────────────┴──────┘
///
/// 1. landmarks, as the sparse solver does it (sparse/steps/), at λ = 0:  H_pp ← H_pp − Σ_l H_pl H_ll⁺ H_lp
/// 2. dropped poses, speeds and biases, one dense block:  H_kk − H_kd H_dd⁺ H_dk
/// 3. back to a residual:  H = JᵀJ, b = −Jᵀr₀
///
/// This folder, `marginalize/`, turns edges that leave a problem into a prior. In: edges and the vertices to drop. Out: a
/// Prior, which EdgePrior makes an edge of. The estimators call Marginalize; marginalization_error.h (OKVIS) and
/// marginalization_info.h (VINS-Mono) are the graded forms and give the same prior; qr_elimination.h never forms H.
/// Reading order: edge_prior.h, this file, square_root.h, drop_ordering.h.

#include <optional>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/marginalize/square_root.h"

namespace ch5 {

/// The normal equations after the Schur complement, before they are factored:  H Δx = b on the kept vertices.
struct MarginalSystem {
  std::vector<std::shared_ptr<Vertex>> kept;  ///< in order of id
  MatXX H;                                    ///< n×n, n = Σ LocalDimension
  VecX b;                                     ///< n×1
  VecX scale;                                 ///< n×1, H's diagonal before anything was eliminated
};

/// Linearizes the edges at the present states and eliminates `drop`. Fixed vertices have no columns. The edges do
/// not change, the vertices' OrderingIds do (drop_ordering.h); the caller removes them and the dropped vertices from the graph.
/// @param edges  at least one, each once;  @param drop  vertices of these edges; fixed ones are ignored
/// @throws std::invalid_argument if there is no edge, one is listed twice or null, a vertex to drop is at none of them, or
///         an edge connects two dropped landmarks
MarginalSystem EliminateVertices(const std::vector<std::shared_ptr<Edge>>& edges,
                                 const std::vector<std::shared_ptr<Vertex>>& drop);

/// EliminateVertices, then FactorNormalEquations: by pivoted Cholesky, or, given a cutoff, by eigenvalues. x0 are the
/// present states.
Prior Marginalize(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  const std::optional<EigenvalueCutoff>& cutoff = std::nullopt);

/// The same within a graph: the edges at the vertices to drop, each once, and these vertices leave it, and one prior on
/// their neighbors takes their place. To first order at the present states the rest of the graph has the same minimum and
/// the same covariances as before. The prior's Jacobian stays that of these states: a neighbor that moves far from them
/// is linearized elsewhere by its other edges, and the two together know more than was measured, of yaw above all. Where
/// that matters, linearize the others at the prior's first estimates too (first_estimates.h).
/// Edges of other levels than 0 are ignored (Edge::Level): they leave too, but the prior contains nothing of them.
/// Landmarks that stay are tied to one another by it, which a solver that eliminates landmarks refuses: drop them too.
/// @return the prior, which is in the graph; null if no free vertex is a neighbor, so that nothing remains to be known
/// @throws GraphError if a vertex is not in this graph, or an edge's numbers are not finite; std::invalid_argument as
///         EliminateVertices. The graph is then as it was
std::shared_ptr<EdgePrior> MarginalizeInto(Graph* graph, const std::vector<std::shared_ptr<Vertex>>& drop);

}  // namespace ch5
