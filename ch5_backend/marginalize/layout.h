#pragma once
/// Which vertices are kept, which are dropped, and their columns: the bookkeeping that every way of marginalising shares.

#include <memory>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// The columns of the dense part (kept vertices, then dropped ones that are not landmarks), and the edges of each dropped
/// landmark. Everything is ordered by id, never by address, so that results repeat to the bit.
struct Layout {
  /// An edge and where `columns` holds the entries of its vertices.
  struct EdgeColumns {
    Edge* edge;
    size_t first;
  };
  // An entry of `columns` is a vertex's first column in the dense part, or one of these:
  static constexpr int kLandmark = -1;  ///< the dropped landmark of this edge
  static constexpr int kFixed = -2;     ///< a fixed vertex, without columns

  std::vector<std::shared_ptr<Vertex>> kept, dropped;  ///< the dense part, in this order
  std::vector<std::shared_ptr<Vertex>> landmarks;      ///< dropped
  std::vector<std::vector<EdgeColumns>> landmark_edges;
  std::vector<EdgeColumns> dense_edges;
  int kept_size = 0, size = 0;  ///< columns of the kept vertices, of the dense part
  std::vector<int> columns;     ///< of the vertices of all edges

  const int* ColumnsOf(const EdgeColumns& edge) const { return columns.data() + edge.first; }
};

/// @throws std::invalid_argument if an edge connects two dropped landmarks
Layout MakeLayout(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop);

}  // namespace ch5
