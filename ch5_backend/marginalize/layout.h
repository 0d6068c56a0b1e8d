#pragma once
/// Who stays, who goes, and where: the bookkeeping that every way of marginalising shares.

#include <memory>
#include <unordered_map>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5 {

/// Columns of the dense part (kept vertices, then dropped ones that are not landmarks), and the edges of each dropped
/// landmark. Everything is in order of id, never of address, so that results repeat to the bit.
struct Layout {
  std::vector<std::shared_ptr<Vertex>> kept, dropped;  // dense columns, in this order
  std::vector<std::shared_ptr<Vertex>> landmarks;
  std::unordered_map<const Vertex*, int> column;    // of the dense part
  std::unordered_map<const Vertex*, int> landmark;  // number of a dropped landmark
  std::vector<std::vector<Edge*>> landmark_edges;
  std::vector<Edge*> dense_edges;
  int kept_size = 0, size = 0;
};

/// @throws std::invalid_argument if an edge ties two dropped landmarks
Layout MakeLayout(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop);

}  // namespace ch5
