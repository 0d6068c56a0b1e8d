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

#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/marginalize/square_root.h"

namespace ch5 {

/// The normal equations after the Schur complement, before they are factored:  H Δx = b on the kept vertices.
struct MarginalSystem {
  std::vector<std::shared_ptr<Vertex>> kept;  ///< in order of id
  MatXX H;                                    ///< n×n, n = Σ LocalDimension
  VecX b;                                     ///< n×1
};

/// Linearizes the edges at the present states and eliminates `drop`. Fixed vertices have no columns. The edges do
/// not change, the vertices' OrderingIds do (drop_ordering.h); the caller removes them and the dropped vertices from the graph.
/// @param edges  at least one, each once;  @param drop  vertices of these edges; fixed ones are ignored
/// @throws std::invalid_argument if there is no edge, one stands twice or is null, a vertex to drop is at none of them, or
///         an edge connects two dropped landmarks
MarginalSystem EliminateVertices(const std::vector<std::shared_ptr<Edge>>& edges,
                                 const std::vector<std::shared_ptr<Vertex>>& drop);

/// EliminateVertices, then FactorNormalEquations: by pivoted Cholesky, or, given a cutoff, by eigenvalues. x0 are the
/// present states.
Prior Marginalize(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  const std::optional<EigenvalueCutoff>& cutoff = std::nullopt);

}  // namespace ch5
