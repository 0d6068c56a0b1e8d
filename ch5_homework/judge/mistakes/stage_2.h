#pragma once
/// What typical mistakes in TestMarginalize make of H and b after the move, and of the prior.

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/formula.h"

namespace ch5::homework::stage_2 {

using Order = std::vector<int>;  // Order[k] = the former place of the variable that stands at k

// The order that is asked: the others keep theirs, the marginalized variable goes behind them.
inline Order KeepingOrder(int n, int idx, int dim) {
  Order order;
  for (int k = 0; k < n; ++k) {
    if (k < idx || k >= idx + dim) order.push_back(k);
  }
  for (int k = idx; k < idx + dim; ++k) order.push_back(k);
  return order;
}

// Accepted too: the variable changes places with the last ones.
inline Order Exchanging(int n, int idx, int dim) {
  Order order(n);
  std::iota(order.begin(), order.end(), 0);
  for (int k = dim - 1; k >= 0; --k) std::swap(order[idx + k], order[n - dim + k]);
  return order;
}

inline MatXX MoveRows(const MatXX& A, const Order& order) {
  MatXX moved(A.rows(), A.cols());
  for (size_t k = 0; k < order.size(); ++k) moved.row(static_cast<int>(k)) = A.row(order[k]);
  return moved;
}
inline MatXX MoveColumns(const MatXX& A, const Order& order) { return MoveRows(A.transpose(), order).transpose(); }
inline MatXX Move(const MatXX& H, const Order& order) { return MoveColumns(MoveRows(H, order), order); }

inline Names VariableNames(const Order& order) {
  Names names;
  for (const int k : order) names.push_back({"2.variable_given_H", {{"n", Word(k)}}});
  return names;
}

/// How rows may move, by Eigen's rows; columns do it transposed.
struct Mover {
  Text cause;  ///< empty if it is right
  std::function<MatXX(const MatXX& A)> move;
};

// The variable changes places with its neighbor only.
inline Order WithItsNeighbor(int n, int idx, int dim) {
  Order order(n);
  std::iota(order.begin(), order.end(), 0);
  const auto begin = order.begin() + idx;
  std::rotate(begin, begin + dim, begin + dim + std::min(dim, n - idx - dim));
  return order;
}

// Row by row to the end, from idx upwards, though the rows behind move up each time.
inline Order OneByOne(int n, int idx, int dim) {
  Order order(n);
  std::iota(order.begin(), order.end(), 0);
  for (auto from = order.begin() + idx; from != order.begin() + idx + dim; ++from) {
    std::rotate(from, from + 1, order.end());
  }
  return order;
}

/// `rows` is what moves: "2.rows", "2.columns" or "2.entries_b".
inline std::vector<Mover> Movers(const Order& order, int idx, int dim, const Text& rows) {
  const int n = static_cast<int>(order.size()), tail = n - idx - dim;
  Order front = order, backwards = order;  // the marginalized variable first; or its rows in the other order
  std::rotate(front.begin(), front.end() - dim, front.end());
  std::reverse(backwards.end() - dim, backwards.end());
  Order inverse(order.size());
  for (int k = 0; k < n; ++k) inverse[order[k]] = k;
  const Order neighbor = WithItsNeighbor(n, idx, dim), one_by_one = OneByOne(n, idx, dim);
  const auto partly = [=](bool others, int own_at) {
    return [=](const MatXX& A) {
      MatXX moved = A;
      if (others) moved.middleRows(idx, tail) = A.bottomRows(tail);
      if (own_at >= 0 && own_at + dim <= n) moved.middleRows(own_at, dim) = A.middleRows(idx, dim);
      return moved;
    };
  };
  const auto first_alone = [=](int own_at) {
    return [=](const MatXX& A) {
      MatXX moved = partly(true, -1)(A);
      moved.row(own_at) = A.row(idx);
      return moved;
    };
  };
  const auto first_three = [=](const MatXX& A) {
    MatXX moved = A;
    const auto three = std::min<Eigen::Index>(3, A.cols());
    moved.leftCols(three) = MoveRows(A, order).leftCols(three);
    return moved;
  };
  std::vector<Mover> movers{
      {{}, [=](const MatXX& A) { return MoveRows(A, order); }},
      {{"2.not_moved", {{"rows", rows}}}, [](const MatXX& A) { return A; }},
      {"2.variable_moved_front", [=](const MatXX& A) { return MoveRows(A, front); }},
      {"2.swapped_with_neighbor", [=](const MatXX& A) { return MoveRows(A, neighbor); }},
      {{"2.lands_at_idx_plus_dim", {{"rows", rows}}}, partly(true, idx + dim)},
      {{"2.variable_lost", {{"rows", rows}}}, partly(true, -1)},
      {{"2.read_after_overwriting", {{"rows", rows}}},
       [=](const MatXX& A) {
         MatXX moved = A;
         moved.middleRows(idx, tail) = A.bottomRows(tail);
         moved.bottomRows(dim) = moved.middleRows(idx, dim).eval();
         return moved;
       }},
      {{"2.others_not_moved_up", {{"rows", rows}}}, partly(false, n - dim)},
      {{"2.one_by_one", {{"rows", rows}}}, [=](const MatXX& A) { return MoveRows(A, one_by_one); }},
      {{"2.reverse_order", {{"rows", rows}}}, [=](const MatXX& A) { return MoveRows(A, backwards); }},
      {{"2.inverse_permutation", {{"rows", rows}}}, [=](const MatXX& A) { return MoveRows(A, inverse); }},
      {{"2.written_over_first", {{"rows", rows}}}, partly(true, 0)},
      {{"2.first_three_entries", {{"rows", rows}}}, first_three}};
  if (dim > 1) {
    for (const int own_at : {n - dim, n - 1})
      movers.push_back({{"2.first_alone", {{"rows", rows}}}, first_alone(own_at)});
  }
  return movers;
}

inline std::vector<Mistake> MoveMistakes(const MatXX& H, const Order& order, int idx, int dim) {
  MatXX before_moved = MoveColumns(H, order);
  before_moved.leftCols(idx) = MoveRows(H, order).leftCols(idx);
  std::vector<Mistake> mistakes{{"2a", "2.nothing_moved", H},
                                {"2a", "2.columns_moved", MoveColumns(H, order)},
                                {"2b", "2.rows_moved", MoveRows(H, order)},
                                {"2b", "2.columns_before_rows_moved", before_moved}};
  for (const Mover& rows : Movers(order, idx, dim, "2.rows")) {
    for (const Mover& columns : Movers(order, idx, dim, "2.columns")) {
      const Text cause = rows.cause.empty() ? columns.cause : rows.cause;
      if (cause.empty()) continue;
      mistakes.push_back({rows.cause.empty() ? "2b" : "2a", cause, columns.move(rows.move(H).transpose()).transpose()});
    }
  }
  return mistakes;
}

inline std::vector<Mistake> MoveMistakesInB(const VecX& b, const Order& order, int idx, int dim) {
  std::vector<Mistake> mistakes{{"2a", "2.b_not_moved", b},
                                {"2b", "2.b_moved_twice", MoveRows(MoveRows(b, order), order)}};
  for (const Mover& entries : Movers(order, idx, dim, "2.entries_b")) {
    if (!entries.cause.empty()) mistakes.push_back({"2a", entries.cause, entries.move(b)});
  }
  return mistakes;
}

}  // namespace ch5::homework::stage_2
