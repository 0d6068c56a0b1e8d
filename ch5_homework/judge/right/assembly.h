#pragma once
/// Stages 1.1, 6c, 7b and 7c: H = Σ JᵀW_ρJ and b = ∓Σ ρ'JᵀWr as loops over edges and pairs of their vertices add them up.

#include <functional>
#include <string>
#include <vector>

#include "ch5_homework/judge/right/formulas.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework::right {

/// Where the rows of an edge's vertex k begin; negative: nowhere.
using RowOf = std::function<int(const Edge& edge, size_t k)>;

struct Loop {
  EdgeList edges;
  int size;
  double sign_of_b;
  const char* name = "H";  ///< of the matrix
  RowOf row_of = [](const Edge& edge, size_t k) { return edge.Vertices()[k]->OrderingId(); };

  /// Where a student writes J_iᵀ W_ρ J_j, adds it at (i, j) and at (j, i), and adds to b.
  std::string todo_block = {}, todo_first = {}, todo_mirror = {}, todo_b = {};
  struct WrongRow {
    Text name;
    RowOf row_of;
  };
  std::vector<WrongRow> wrong_rows = {};                                             ///< the stage's own
  std::function<std::vector<Text>(const Vertex& i, const Vertex& j)> parts_of = {};  ///< of H, to which a block belongs
};

struct AssembledSystem {
  Formula H, b;

  explicit AssembledSystem(const Loop& loop);
};

}  // namespace ch5::homework::right
