#pragma once
/// Who stays, who goes, and where: the bookkeeping that every way of marginalising shares.

#include <memory>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// Columns of the dense part (kept vertices, then dropped ones that are not landmarks), and the edges of each dropped
/// landmark. Everything is in order of id, never of address, so that results repeat to the bit.
struct Layout {
  /// An edge, and for each of its vertices its first column of the dense part, or one of the words below.
  struct Row {
    Edge* edge;
    size_t first;  ///< in `columns`
  };
  static constexpr int kLandmark = -1;  ///< the dropped landmark whose edge it is
  static constexpr int kFixed = -2;     ///< no columns at all

  std::vector<std::shared_ptr<Vertex>> kept, dropped;  // dense columns, in this order
  std::vector<std::shared_ptr<Vertex>> landmarks;
  std::vector<std::vector<Row>> landmark_edges;
  std::vector<Row> dense_edges;
  int kept_size = 0, size = 0;
  std::vector<int> columns;  // of all rows' vertices

  const int* ColumnsOf(const Row& row) const { return columns.data() + row.first; }
};

/// @throws std::invalid_argument if an edge ties two dropped landmarks
Layout MakeLayout(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop);

}  // namespace ch5
