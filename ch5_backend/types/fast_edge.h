#pragma once
/// What an edge may offer beside Edge's functions, for the sparse solver and for marginalisation. All of it is optional:
/// an edge without it is linearised by Edge's own functions, to the same numbers.
///
///   class EdgeReprojection : public SizedEdge<2, …>, public FastEdge { … };

#include <memory>
#include <vector>

#include "ch5_backend/graph/edge.h"
#include "ch5_backend/types/edge_batch.h"

namespace ch5 {

class FastEdge {
 public:
  virtual ~FastEdge() = default;

  /// r, and each J_i whose address is not null (column-major), at the present state, into the caller's memory; the edge
  /// itself is left as it is. @return false if the type does not offer it
  virtual bool LinearizeInto(double* /*r*/, double* const* /*J*/) const { return false; }
  /// An empty batch for edges of this type (edge_batch.h), or null if there is none.
  virtual std::unique_ptr<EdgeBatch> MakeBatch() const { return nullptr; }
  /// For an edge that gets JᵀJ more cheaply than from J: the lower half of C = [J r]ᵀ[J r] at the present state, over the
  /// columns of all its vertices in their order, (n + 1)×(n + 1), column-major; r is left computed, J is not.
  /// @return false if the type does not offer it, or if W or a loss would make it another matrix
  virtual bool ProductsInto(double* /*C*/) { return false; }
};

/// The edge's fast side, or null if it has none.
inline FastEdge* AsFast(Edge* edge) { return dynamic_cast<FastEdge*>(edge); }
inline const FastEdge* AsFast(const Edge& edge) { return dynamic_cast<const FastEdge*>(&edge); }

/// FastEdge::ProductsInto over some of the columns, the residual's among them, negative: C = −[J r]ᵀ[J r], lower half,
/// column-major. @return false if the edge has no products of its own
bool NegativeProducts(Edge* edge, const std::vector<int>& columns, double* C);

}  // namespace ch5
