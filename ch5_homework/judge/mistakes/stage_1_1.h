#pragma once
/// What typical mistakes in MakeHessian make of H and b.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_homework/judge/diagnosis.h"

namespace ch5::homework::stage_1_1 {

/// One turn of MakeHessian's inner loop.
struct Turn {
  MatXX block, without_loss, first_order;  ///< J_iᵀW_ρJ_j, J_iᵀWJ_j, ρ'J_iᵀWJ_j
  MatXX without_weight;                    ///< J_iᵀJ_j
  double drho;                             ///< ρ'
  int i, j;                                ///< where v_i and v_j begin
  bool diagonal;                           ///< v_i is v_j
  int at_i, at_j;                          ///< their numbers in the edge's list
  int id_i, id_j;                          ///< and in the graph
};

/// How a student may put the block into H.
using Placement = void (*)(MatXX* H, const Turn& turn);

// Blocks that would not fit (there, Eigen's assertion ends the student's run) are left out.
inline void Add(MatXX* H, int row, int column, const MatXX& block) {
  if (row + block.rows() > H->rows() || column + block.cols() > H->cols()) return;
  H->block(row, column, block.rows(), block.cols()) += block;
}
inline void Set(MatXX* H, int row, int column, const MatXX& block) {
  if (row + block.rows() > H->rows() || column + block.cols() > H->cols()) return;
  H->block(row, column, block.rows(), block.cols()) = block;
}
inline void AddBoth(MatXX* H, const Turn& t, const MatXX& block) {
  Add(H, t.i, t.j, block);
  if (!t.diagonal) Add(H, t.j, t.i, block.transpose());
}

/// `share(edge, drho, W_rho, i, j)` for every pair of free vertices of every edge, i ≤ j.
template <typename Share>
void ForEachTurn(const Graph& graph, const Share& share) {
  for (const auto& edge : graph.Edges()) {
    double drho;
    MatXX W;
    edge->RobustInfo(&drho, &W);
    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      for (size_t j = i; j < vertices.size(); ++j) {
        if (!vertices[i]->IsFixed() && !vertices[j]->IsFixed()) share(*edge, drho, W, i, j);
      }
    }
  }
}

inline MatXX Assemble(const Graph& graph, int size, Placement place) {
  MatXX H = MatXX::Zero(size, size);
  ForEachTurn(graph, [&](const Edge& edge, double drho, const MatXX& W, size_t i, size_t j) {
    const MatXX Jt = edge.Jacobian(i).transpose(), J = edge.Jacobian(j), plain = Jt * edge.Information() * J;
    place(&H, {Jt * W * J, plain, drho * plain, Jt * J, drho, edge.Vertices()[i]->OrderingId(),
               edge.Vertices()[j]->OrderingId(), i == j, static_cast<int>(i), static_cast<int>(j),
               edge.Vertices()[i]->Id(), edge.Vertices()[j]->Id()});
  });
  return H;
}

struct PlacementMistake {
  const char* todo;
  Text cause;
  Placement place;
};

inline const PlacementMistake kPlacementMistakes[] = {
    {"1.1b", "1.1.mirror_missing", [](MatXX* H, const Turn& t) { Add(H, t.i, t.j, t.block); }},
    {"1.1b", "1.1.mirror_not_transposed",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block);
     }},
    {"1.1a", "1.1.hessian_transposed",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block.transpose());
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "1.1.both_blocks_assigned_not_added",
     [](MatXX* H, const Turn& t) {
       Set(H, t.i, t.j, t.block);
       if (!t.diagonal) Set(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "1.1.block_assigned_not_added",
     [](MatXX* H, const Turn& t) {
       Set(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1b", "1.1.mirror_assigned_not_added",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Set(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "1.1.places_exchanged",
     [](MatXX* H, const Turn& t) {
       Add(H, t.j, t.i, t.block);
       if (!t.diagonal) Add(H, t.i, t.j, t.block.transpose());
     }},
    {"1.1a", "1.1.row_column_exchanged",
     [](MatXX* H, const Turn& t) {
       Add(H, t.j, t.i, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1b", "1.1.mirror_at_same_place",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.i, t.j, t.block.transpose());
     }},
    {"1.1b", "1.1.diagonal_blocks_added_twice",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "1.1.blocks_subtracted",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, -t.block);
       if (!t.diagonal) Add(H, t.j, t.i, -t.block.transpose());
     }},
    {"1.1a", "1.1.block_missing",
     [](MatXX* H, const Turn& t) {
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "1.1.only_diagonal_blocks_arrive",
     [](MatXX* H, const Turn& t) {
       if (t.diagonal) Add(H, t.i, t.j, t.block);
     }},
    {"1.1c 1.1a", "1.1.loss_forgotten", [](MatXX* H, const Turn& t) { AddBoth(H, t, t.without_loss); }},
    {"1.1c 1.1a", "1.1.first_order_loss", [](MatXX* H, const Turn& t) { AddBoth(H, t, t.first_order); }},
    {"1.1b", "1.1.loss_forgotten_mirrored_block",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.without_loss.transpose());
     }},
    {"1.1a", "1.1.only_one_triangle",
     [](MatXX* H, const Turn& t) {
       Add(H, std::min(t.i, t.j), std::max(t.i, t.j), t.i <= t.j ? t.block : MatXX(t.block.transpose()));
     }},
    {"1.1a", "1.1.only_one_triangle",
     [](MatXX* H, const Turn& t) {
       Add(H, std::max(t.i, t.j), std::min(t.i, t.j), t.i >= t.j ? t.block : MatXX(t.block.transpose()));
     }},
    {"1.1b", "1.1.mirror_only_if_v_i_first",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (t.i < t.j) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "1.1.moved_to_triangle_not_transposed",
     [](MatXX* H, const Turn& t) {
       Add(H, std::min(t.i, t.j), std::max(t.i, t.j), t.block);
       if (!t.diagonal) Add(H, std::max(t.i, t.j), std::min(t.i, t.j), t.block.transpose());
     }},
    {"1.1a", "1.1.block_only_if_v_i_first",
     [](MatXX* H, const Turn& t) {
       if (t.i <= t.j) AddBoth(H, t, t.block);
     }},
    {"1.1a", Text("1.1.numbers_in_edge_for_rows", {{"this", Word("index_i")}, {"that", Word("index_j")}}),
     [](MatXX* H, const Turn& t) {
       Add(H, t.at_i, t.at_j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", Text("1.1.numbers_in_edge_for_rows", {{"this", Word("index_i")}, {"that", Word("index_j")}}),
     [](MatXX* H, const Turn& t) {
       Add(H, t.at_i, t.at_j, t.block);
       if (!t.diagonal) Add(H, t.at_j, t.at_i, t.block.transpose());
     }},
    {"1.1b", Text("1.1.numbers_in_edge_for_rows", {{"this", Word("index_j")}, {"that", Word("index_i")}}),
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.at_j, t.at_i, t.block.transpose());
     }},
    {"1.1a", "1.1.id_for_first_row",
     [](MatXX* H, const Turn& t) {
       const int i = t.id_i * static_cast<int>(t.block.rows()), j = t.id_j * static_cast<int>(t.block.cols());
       Add(H, i, j, t.block);
       if (!t.diagonal) Add(H, j, i, t.block.transpose());
     }},
    {"1.1a", "1.1.only_first_block_kept",
     [](MatXX* H, const Turn& t) {
       if (H->block(t.i, t.j, t.block.rows(), t.block.cols()).isZero(0.0)) Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "1.1.only_first_block_kept",
     [](MatXX* H, const Turn& t) {
       if (H->block(t.i, t.j, t.block.rows(), t.block.cols()).isZero(0.0)) AddBoth(H, t, t.block);
     }},
    {"1.1a", "1.1.block_added_twice",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, 2.0 * t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1b", "formula.mirror_added_twice",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, 2.0 * t.block.transpose());
     }},
    {"1.1b", "formula.mirror_subtracted",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, -t.block.transpose());
     }},
    {"1.1a", "1.1.both_at_one_place",
     [](MatXX* H, const Turn& t) {
       if (t.block.rows() == t.block.cols()) Add(H, t.i, t.j, t.block + t.block.transpose());
     }},
    {"1.1c 1.1a", "1.1.weight_missing", [](MatXX* H, const Turn& t) { AddBoth(H, t, t.without_weight); }},
    {"1.1b", "1.1.weight_missing_mirror",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.without_weight.transpose());
     }},
    {"1.1c 1.1a", Text("formula.acts_twice", {{"this", Word("ρ'")}, {"that", Word("W_ρ")}}),
     [](MatXX* H, const Turn& t) { AddBoth(H, t, t.drho * t.block); }},
    {"1.1b", "1.1.mirror_takes_sum",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       const MatXX sum = H->block(t.i, t.j, t.block.rows(), t.block.cols());
       if (!t.diagonal) Add(H, t.j, t.i, sum.transpose());
     }},
    {"1.1a", "1.1.nothing_added_H", [](MatXX*, const Turn&) {}},
};

inline std::vector<Mistake> MistakesInH(const Graph& graph, int size) {
  std::vector<Mistake> mistakes;
  for (const PlacementMistake& mistake : kPlacementMistakes) {
    const Placement place = mistake.place;
    mistakes.push_back({mistake.todo, mistake.cause, [&graph, size, place] { return Assemble(graph, size, place); }});
  }
  const Placement twice = [](MatXX* H, const Turn& t) { AddBoth(H, t, 2.0 * t.block); };
  mistakes.push_back({"1.1a", "1.1.H_doubled", [&graph, size, twice] { return Assemble(graph, size, twice); }});
  return mistakes;
}

/// Which vertices' shares one turn of the inner loop adds to b; the right b takes v_i's in the turn with itself.
using Takes = void (*)(bool diagonal, double* of_i, double* of_j);

inline VecX AssembleB(const Graph& graph, int size, Takes takes, bool with_loss = true, bool with_W_rho = false) {
  VecX b = VecX::Zero(size);
  ForEachTurn(graph, [&](const Edge& edge, double drho, const MatXX& W_rho, size_t i, size_t j) {
    const MatXX W = with_W_rho ? W_rho : MatXX((with_loss ? drho : 1.0) * edge.Information());
    double of_i = 0.0, of_j = 0.0;
    takes(i == j, &of_i, &of_j);
    for (const auto& [k, times] : {std::pair{i, of_i}, std::pair{j, of_j}}) {
      const Vertex& v = *edge.Vertices()[k];
      b.segment(v.OrderingId(), v.LocalDimension()) -= times * edge.Jacobian(k).transpose() * W * edge.Residual();
    }
  });
  return b;
}

/// b of code that writes to the rows of vertex i once for each edge, when j is i; `write` may add or assign.
template <class Write>
std::function<MatXX()> WrittenOnTheDiagonal(const Graph& graph, int size, const Write& write) {
  return [=, &graph] {
    VecX b = VecX::Zero(size);
    ForEachTurn(graph, [&](const Edge& edge, double drho, const MatXX&, size_t i, size_t j) {
      const Vertex& v = *edge.Vertices()[i];
      if (i == j) write(b.segment(v.OrderingId(), v.LocalDimension()), edge, drho, edge.Jacobian(i));
    });
    return MatXX(b);
  };
}

inline std::vector<Mistake> MistakesInB(const Graph& graph, int size) {
  const auto is = [&graph, size](Takes takes, bool with_loss = true, bool with_W_rho = false) {
    return [=, &graph] { return MatXX(AssembleB(graph, size, takes, with_loss, with_W_rho)); };
  };
  const Takes right = [](bool diagonal, double* of_i, double*) { *of_i = diagonal; };
  const Text mirror = "1.1.b_added_in_mirror";
  const Text pairs = "1.1.b_added_with_each_block";
  return {{"1.1d 1.1b", "1.1.sign_b", is([](bool diagonal, double* of_i, double*) { *of_i = -1.0 * diagonal; })},
          {"1.1d 1.1b", "1.1.b_doubled", is([](bool diagonal, double* of_i, double*) { *of_i = 2.0 * diagonal; })},
          {"1.1b", mirror, is([](bool diagonal, double* of_i, double* of_j) { *(diagonal ? of_i : of_j) = 1.0; })},
          {"1.1b", mirror, is([](bool, double* of_i, double*) { *of_i = 1.0; })},
          {"1.1b", mirror, is([](bool diagonal, double* of_i, double* of_j) {
             *of_i = 1.0;
             *of_j = !diagonal;
           })},
          {"1.1a", pairs, is([](bool diagonal, double* of_i, double*) { *of_i = 1.0 + diagonal; })},
          {"1.1a", pairs, is([](bool diagonal, double* of_i, double* of_j) {
             *of_i = diagonal;
             *of_j = 1.0;
           })},
          {"", "1.1.weight_missing_b",
           WrittenOnTheDiagonal(graph, size,
                                [](auto rows, const Edge& edge, double drho, const MatXX& J_i) {
                                  rows -= drho * J_i.transpose() * edge.Residual();
                                })},
          {"", "1.1.last_edge_left_in_b",
           WrittenOnTheDiagonal(graph, size,
                                [](auto rows, const Edge& edge, double drho, const MatXX& J_i) {
                                  rows = -drho * J_i.transpose() * edge.Information() * edge.Residual();
                                })},
          {"", "1.1.loss_forgotten_b", is(right, false)},
          {"", "1.1.W_rho_in_b", is(right, true, true)}};
}

}  // namespace ch5::homework::stage_1_1
