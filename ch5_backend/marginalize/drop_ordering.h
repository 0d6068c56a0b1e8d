#pragma once
/// The order of the unknowns when vertices are to be dropped: kept ones, dropped ones that are not landmarks, dropped
/// landmarks. The solver's steps then eliminate the last as they do in any graph (sparse/steps/eliminate.h).

#include "ch5_backend/graph/ordering.h"

namespace ch5 {

/// Everything is ordered by id, never by address, so that results repeat to the bit.
struct DropOrdering {
  Ordering ordering;  ///< its poses are the kept vertices, then the dropped ones; its landmarks are dropped
  int num_kept = 0;   ///< so many poses are kept,
  int kept_size = 0;  ///< with so many rows
};

/// @throws std::invalid_argument if there is no edge, one is listed twice or null, or a vertex to drop is null or at none of them
void CheckMarginalization(const std::vector<std::shared_ptr<Edge>>& edges,
                          const std::vector<std::shared_ptr<Vertex>>& drop);

/// Those of the vertices that are fixed or at one of the edges, in their order. Overwrites the OrderingIds of all.
std::vector<std::shared_ptr<Vertex>> FixedOrAtEdges(std::vector<std::shared_ptr<Vertex>> vertices,
                                                    const std::vector<std::shared_ptr<Edge>>& edges);

/// Gives the free vertices of the edges their OrderingIds, and fixed ones −1, until another ordering is made.
/// @param drop  those that are fixed or without an edge are ignored
DropOrdering MakeDropOrdering(const std::vector<std::shared_ptr<Edge>>& edges,
                              const std::vector<std::shared_ptr<Vertex>>& drop);

}  // namespace ch5
