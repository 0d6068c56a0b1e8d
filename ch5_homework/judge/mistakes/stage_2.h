#pragma once
/// What typical mistakes in TestMarginalize make of H and b after the move, and of the prior.

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/mistakes/elimination.h"
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

/// H and b, moved and taken apart: r remains, m goes.
struct Parts : PartedSystem {
  MatXX H, A_mr;
  VecX b;

  Parts(const MatXX& H_moved, const VecX& b_moved, int dim)
      : PartedSystem(H_moved, b_moved, H_moved.rows() - dim), H(H_moved), A_mr(A_rm.transpose()), b(b_moved) {}
  using PartedSystem::Reduced;
  /// With something else in place of the parts of b.
  VecX Reduced(const VecX& other_r, const VecX& other_m) const { return other_r - A_rm * A_mm_inverse * other_m; }
};

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

// The three blocks, each read at its place or at another one.
inline std::vector<Mistake> CornerMistakes(const Parts& r, int idx) {
  struct Block {
    Text cause;  // empty if it is right
    MatXX A;
  };
  const auto n = r.A_rr.rows(), m = r.A_mm.rows();
  const MatXX& H = r.H;
  const Text rm = "2.Arm_read_wrong_column";
  const Text mr = "2.Amr_read_wrong_row";
  const Text rr = "2.Arr_read_wrong_place";
  const auto at = std::min<Eigen::Index>(idx, n);
  std::vector<Mistake> mistakes;
  for (const Block& A_rr : {Block{{}, r.A_rr}, {rr, H.bottomRightCorner(n, n)}, {rr, H.topRightCorner(n, n)}}) {
    for (const Block& A_rm :
         {Block{{}, r.A_rm}, {rm, H.topLeftCorner(n, m)}, {rm, H.block(0, at, n, m)}, {rm, H.bottomLeftCorner(n, m)}}) {
      for (const Block& A_mr :
           {Block{{}, r.A_mr}, {mr, H.topLeftCorner(m, n)}, {mr, H.block(at, 0, m, n)}, {mr, H.topRightCorner(m, n)}}) {
        const Text cause = !A_rr.cause.empty() ? A_rr.cause : (!A_rm.cause.empty() ? A_rm.cause : A_mr.cause);
        if (cause.empty()) continue;
        mistakes.push_back({"2c", cause, A_rr.A - A_rm.A * r.A_mm_inverse * A_mr.A});
      }
    }
  }
  return mistakes;
}

/// Corners of one size, which Eigen lets exchange.
inline std::vector<Mistake> ExchangeMistakes(const Parts& r) {
  if (r.A_rm.rows() != r.A_rm.cols()) return {};
  return {{"2c", "2.A_rm_A_mr_exchanged", r.A_rr - r.A_mr * r.A_mm_inverse * r.A_rm},
          {"2c", "2.A_mr_holds_A_rm", r.A_rr - r.A_rm * r.A_mm_inverse * r.A_rm},
          {"2c", "2.A_rm_holds_A_mr", r.A_rr - r.A_mr * r.A_mm_inverse * r.A_mr},
          {"2c", "2.A_rr_corner_goes", r.A_mm - r.A_rm * r.A_mm_inverse * r.A_mr}};
}

/// Where A_mm is singular, NaN or infinity comes of its inverse: then what the student has is the answer.
inline Mistake InverseOfSingular(const MatXX& got) {
  return {"2e 2d", "2.inverse_of_a_singular_matrix", got.allFinite() ? MatXX() : got};
}

inline std::vector<Mistake> PriorMistakes(const Parts& r, int idx, const MatXX& got) {
  const auto m = r.A_mm.rows();
  const MatXX one = MatXX::Identity(m, m);
  std::vector<Mistake> mistakes =
      CutMistakes("2e 2d", "A_mm", r.A_mm, [&](const MatXX& middle) { return r.Schur(middle); });
  const std::vector<Mistake> others{
      InverseOfSingular(got),
      {"2d", "2.sign_added", r.Schur(-r.A_mm_inverse), kOfSign},
      {"2d", "2.last_variable_not_subtracted", idx == r.A_rr.rows() ? r.A_rr : MatXX()},
      {"2d", "2.A_rr_alone", r.A_rr},
      {"2d", AsLargeAs("H_marg"), r.H},
      {"2d", "2.covariance_for_information", PseudoInversePsd(r.H).topLeftCorner(r.A_rr.rows(), r.A_rr.cols())},
      {"2e 2d", "2.divided_by_a_number", r.Schur(one / r.A_mm(0, 0))},
      {"2e 2d", "2.divided_by_a_number", r.Schur(one / r.A_mm.determinant())},
      {"2e 2d", StandsFor("(H⁻¹)_mm", "A_mm⁻¹"), r.Schur(PseudoInversePsd(r.H).bottomRightCorner(m, m))},
      {"2e 2d", "2.inverse_by_entries", r.Schur(r.A_mm.cwiseInverse())}};
  Append(others, &mistakes);
  Append(EliminationMistakesInSchur({"2d", "2e 2d", "A_rr", "A_rm A_mm⁻¹ A_mr", "A_mm⁻¹", "A_mm"}, r), &mistakes);
  Append(ExchangeMistakes(r), &mistakes);
  for (const auto at : {Eigen::Index{0}, std::min<Eigen::Index>(idx, r.A_rr.rows())}) {
    mistakes.push_back({"2e 2d", "2.inverse_wrong_corner", r.Schur(PseudoInversePsd(r.H.block(at, at, m, m)))});
  }
  Append(CornerMistakes(r, idx), &mistakes);
  return mistakes;
}

inline std::vector<Mistake> RightHandSideMistakes(const Parts& r, const VecX& b_given, int idx, const VecX& got) {
  const auto n = r.b_r.size(), m = r.b_m.size();
  const MatXX one = MatXX::Identity(m, m);
  std::vector<Mistake> mistakes{InverseOfSingular(got),
                                {"2d", AsLargeAs("b_marg"), r.b},
                                {"2d", "2.b_m_taken_front_b_marg", r.Reduced(r.b_r, r.b_r.head(m))},
                                {"2d", "2.b_m_taken_idx", r.Reduced(r.b_r, r.b.segment(idx, m))},
                                {"2e 2d", "2.divided_by_a_number", r.Reduced(one / r.A_mm(0, 0))},
                                {"2d", "2.b_r_read_wrong_place", r.Reduced(r.b.tail(n), r.b_m)},
                                {"2d", "2.b_r_b_m_exchanged", r.Reduced(r.b.tail(n), r.b.head(m))},
                                {"2d", "2.b_prior_solved", PseudoInversePsd(r.Schur()) * r.Reduced()},
                                {"2a", "2.b_before_move", r.Reduced(b_given.head(n), b_given.tail(m))},
                                {"2d", "2.b_before_move", r.Reduced(b_given.head(n), r.b_m)},
                                {"2d", "2.b_m_taken_early", r.Reduced(r.b_r, b_given.tail(m))}};
  Append(EliminationMistakesInReduced({"2d", "2d", "b_r", "A_rm A_mm⁻¹ b_m", "A_mm⁻¹", "A_mm"}, r), &mistakes);
  return mistakes;
}

}  // namespace ch5::homework::stage_2
