#pragma once
/// Marginalisation as a function:  edges + vertices to drop → a prior on the rest.
///
///         kept  dropped        landmarks that are dropped
///       ┌──────┬──────┐      ┌───┐
///   H = │ H_kk │ H_kd │  W = │ w │ one thin column block each,   V = small blocks on a diagonal
///       │ H_dk │ H_dd │      │   │
///       └──────┴──────┘      └───┘
///
/// 1. the landmarks, whose V are small and by themselves:  H ← H − Σ w V⁺ wᵀ
/// 2. the dropped poses, one small dense block:  H_kk − H_kd H_dd⁺ H_dk
/// 3. H = JᵀJ, b = −Jᵀr₀ of what remains

#include <optional>

#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/marginalize/square_root.h"

namespace ch5 {

/// What remains after the Schur complement, before it is factored:  H Δx = b on the kept vertices.
struct MarginalSystem {
  std::vector<std::shared_ptr<Vertex>> kept;  ///< in order of id
  MatXX H;                                    ///< n×n, n = Σ LocalDimension
  VecX b;                                     ///< n×1
};

/// Linearises the edges at the present states and eliminates `drop`. Fixed vertices have no columns. The edges are
/// left as they are: who calls takes them, and the dropped vertices, out of the graph.
/// @param edges  at least one;  @param drop  free vertices; those without an edge are ignored
/// @throws std::invalid_argument if an edge ties two dropped landmarks
MarginalSystem EliminateVertices(const std::vector<std::shared_ptr<Edge>>& edges,
                                 const std::vector<std::shared_ptr<Vertex>>& drop);

/// EliminateVertices, then FactorNormalEquations, by Cholesky or by the eigenvalues that a cut leaves; x0 are the present
/// states.
Prior Marginalize(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop,
                  const std::optional<EigenCut>& cut = std::nullopt);

}  // namespace ch5
