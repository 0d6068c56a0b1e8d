#pragma once
/// What typical mistakes in MakeHessian make of H and b.

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_homework/judge/narrate.h"

namespace ch5::homework::stage_1_1 {

/// One turn of MakeHessian's inner loop.
struct Turn {
  MatXX block, without_loss, first_order;  ///< J_iᵀW_ρJ_j, J_iᵀWJ_j, ρ'J_iᵀWJ_j
  MatXX without_weight;                    ///< J_iᵀJ_j
  double drho;                             ///< ρ'
  int i, j;                                ///< where v_i and v_j begin
  bool diagonal;                           ///< v_i is v_j
  int at_i, at_j;                          ///< their numbers in the edge's list
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
               edge.Vertices()[j]->OrderingId(), i == j, static_cast<int>(i), static_cast<int>(j)});
  });
  return H;
}

struct PlacementMistake {
  const char* todo;
  const char* cause;
  Placement place;
};

inline const PlacementMistake kPlacementMistakes[] = {
    {"1.1b", "the mirrored block is missing: H must get J_iᵀWJ_j at (v_i, v_j) and its transpose at (v_j, v_i)",
     [](MatXX* H, const Turn& t) { Add(H, t.i, t.j, t.block); }},
    {"1.1b", "the mirrored block is not transposed: at (v_j, v_i) stands J_iᵀWJ_j itself",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block);
     }},
    {"1.1a", "hessian is transposed at (v_i, v_j): it belongs there as it is, its transpose to (v_j, v_i)",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block.transpose());
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "= where += is meant, in both blocks: each edge overwrites what the edges before it have added",
     [](MatXX* H, const Turn& t) {
       Set(H, t.i, t.j, t.block);
       if (!t.diagonal) Set(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "= where += is meant in the block (v_i, v_j): each edge overwrites what the edges before it have added",
     [](MatXX* H, const Turn& t) {
       Set(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1b", "= where += is meant in the mirrored block: each edge overwrites what the edges before it have added",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Set(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "the places are exchanged: J_iᵀWJ_j went to (v_j, v_i) and its transpose to (v_i, v_j)",
     [](MatXX* H, const Turn& t) {
       Add(H, t.j, t.i, t.block);
       if (!t.diagonal) Add(H, t.i, t.j, t.block.transpose());
     }},
    {"1.1a", "row and column are exchanged: both blocks went to (v_j, v_i)",
     [](MatXX* H, const Turn& t) {
       Add(H, t.j, t.i, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1b", "the mirrored block went to the same place (v_i, v_j) as the first",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.i, t.j, t.block.transpose());
     }},
    {"1.1b", "the diagonal blocks are added twice: the mirror belongs to j ≠ i only",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "the blocks are subtracted: it is b that has the minus sign, H = +JᵀWJ",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, -t.block);
       if (!t.diagonal) Add(H, t.j, t.i, -t.block.transpose());
     }},
    {"1.1a", "the block (v_i, v_j) is missing: only the mirrored one is added",
     [](MatXX* H, const Turn& t) {
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "only the diagonal blocks arrive: those of two different vertices are missing",
     [](MatXX* H, const Turn& t) {
       if (t.diagonal) Add(H, t.i, t.j, t.block);
     }},
    {"1.1a", "the loss is forgotten: `hessian` has its weight already, JᵀW_ρJ; this is JᵀWJ",
     [](MatXX* H, const Turn& t) { AddBoth(H, t, t.without_loss); }},
    {"1.1a", "ρ'W stands where W_ρ is meant: `hessian`, JᵀW_ρJ, holds the second derivative of the loss too",
     [](MatXX* H, const Turn& t) { AddBoth(H, t, t.first_order); }},
    {"1.1b", "the loss is forgotten in the mirrored block: it is the transpose of `hessian`, JᵀW_ρJ",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.without_loss.transpose());
     }},
    {"1.1a", "only one triangle of blocks is filled: H takes each block and its mirror, whichever index is larger",
     [](MatXX* H, const Turn& t) {
       Add(H, std::min(t.i, t.j), std::max(t.i, t.j), t.i <= t.j ? t.block : MatXX(t.block.transpose()));
     }},
    {"1.1a", "only one triangle of blocks is filled: H takes each block and its mirror, whichever index is larger",
     [](MatXX* H, const Turn& t) {
       Add(H, std::max(t.i, t.j), std::min(t.i, t.j), t.i >= t.j ? t.block : MatXX(t.block.transpose()));
     }},
    {"1.1b", "the mirror is written only if v_i stands before v_j in H; edges list their vertices in any order",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (t.i < t.j) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "the block is written only if v_i stands before v_j in H; edges list their vertices in any order",
     [](MatXX* H, const Turn& t) {
       if (t.i <= t.j) AddBoth(H, t, t.block);
     }},
    {"1.1a", "the vertices' numbers in the edge stand where their first rows in H, index_i and index_j, are meant",
     [](MatXX* H, const Turn& t) {
       Add(H, t.at_i, t.at_j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "the vertices' numbers in the edge stand where their first rows in H, index_i and index_j, are meant",
     [](MatXX* H, const Turn& t) {
       Add(H, t.at_i, t.at_j, t.block);
       if (!t.diagonal) Add(H, t.at_j, t.at_i, t.block.transpose());
     }},
    {"1.1b", "the vertices' numbers in the edge stand where their first rows in H, index_j and index_i, are meant",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.at_j, t.at_i, t.block.transpose());
     }},
    {"1.1a", "a block is written only where there was none: each edge must add its share",
     [](MatXX* H, const Turn& t) {
       if (H->block(t.i, t.j, t.block.rows(), t.block.cols()).isZero(0.0)) Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1a", "a block is written only where there was none: each edge must add its share",
     [](MatXX* H, const Turn& t) {
       if (H->block(t.i, t.j, t.block.rows(), t.block.cols()).isZero(0.0)) AddBoth(H, t, t.block);
     }},
    {"1.1a", "the block (v_i, v_j) is added twice, its mirror once",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, 2.0 * t.block);
       if (!t.diagonal) Add(H, t.j, t.i, t.block.transpose());
     }},
    {"1.1b", "the mirrored block is added twice",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, 2.0 * t.block.transpose());
     }},
    {"1.1b", "the mirrored block is subtracted",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       if (!t.diagonal) Add(H, t.j, t.i, -t.block.transpose());
     }},
    {"1.1a", "`hessian` and its transpose are added at one place: the transpose belongs to the mirror place",
     [](MatXX* H, const Turn& t) {
       if (t.block.rows() == t.block.cols()) Add(H, t.i, t.j, t.block + t.block.transpose());
     }},
    {"1.1a", "the weight is missing: JᵀW_ρJ, not JᵀJ",
     [](MatXX* H, const Turn& t) { AddBoth(H, t, t.without_weight); }},
    {"1.1a", "ρ' acts twice: W_ρ has it already", [](MatXX* H, const Turn& t) { AddBoth(H, t, t.drho * t.block); }},
    {"1.1b", "the mirror takes the whole block of H, with what the edges before have added, in place of `hessian`",
     [](MatXX* H, const Turn& t) {
       Add(H, t.i, t.j, t.block);
       const MatXX sum = H->block(t.i, t.j, t.block.rows(), t.block.cols());
       if (!t.diagonal) Add(H, t.j, t.i, sum.transpose());
     }},
    {"1.1a", "nothing was added to H", [](MatXX*, const Turn&) {}},
};

inline std::vector<Mistake> MistakesInH(const Graph& graph, int size) {
  std::vector<Mistake> mistakes;
  for (const PlacementMistake& mistake : kPlacementMistakes) {
    const Placement place = mistake.place;
    mistakes.push_back({mistake.todo, mistake.cause, [&graph, size, place] { return Assemble(graph, size, place); }});
  }
  const Placement twice = [](MatXX* H, const Turn& t) { AddBoth(H, t, 2.0 * t.block); };
  mistakes.push_back({"1.1a", "H is twice too large: it is not set to zero before the edges are added",
                      [&graph, size, twice] { return Assemble(graph, size, twice); }});
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
  const std::string mirror = "b is added in the mirror too: its line stands below, once for each vertex";
  const std::string pairs = "b is added with each block of H too: its line stands below, once for each vertex";
  return {{"", "the sign of b: b = −JᵀWr, as the line that you found there has it",
           is([](bool diagonal, double* of_i, double*) { *of_i = -1.0 * diagonal; })},
          {"", "b is twice too large: it is not set to zero before the edges are added, or added to twice",
           is([](bool diagonal, double* of_i, double*) { *of_i = 2.0 * diagonal; })},
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
          {"", "the weight is missing in b: JᵀWr, not Jᵀr",
           WrittenOnTheDiagonal(graph, size,
                                [](auto rows, const Edge& edge, double drho, const MatXX& J_i) {
                                  rows -= drho * J_i.transpose() * edge.Residual();
                                })},
          {"", "= stands where −= is meant in b: only the last edge's share is left",
           WrittenOnTheDiagonal(graph, size,
                                [](auto rows, const Edge& edge, double drho, const MatXX& J_i) {
                                  rows = -drho * J_i.transpose() * edge.Information() * edge.Residual();
                                })},
          {"", "the loss is forgotten in b: Wr has ρ' in it", is(right, false)},
          {"", "W_ρ is for H; b takes ρ'W", is(right, true, true)}};
}

}  // namespace ch5::homework::stage_1_1
