#pragma once
/// What typical mistakes in TestMarginalize make of H and b after the move, and of the prior.

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/narrate.h"

namespace ch5::homework::stage_2 {

using Order = std::vector<int>;  // Order[k] = the former place of the variable that stands at k

// The order that is asked: the others keep theirs, the marginalised variable goes behind them.
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
  for (const int k : order) names.push_back("variable " + std::to_string(k) + " of the given H");
  return names;
}

/// H and b, moved and taken apart: r remains, m goes.
struct Parts {
  MatXX A_rr, A_rm, A_mr, A_mm, A_mm_inverse;
  VecX b_r, b_m;
  MatXX H;
  VecX b;

  Parts(const MatXX& H_moved, const VecX& b_moved, int dim) : H(H_moved), b(b_moved) {
    const auto n = H.rows() - dim;
    A_rr = H.topLeftCorner(n, n);
    A_rm = H.topRightCorner(n, dim);
    A_mr = H.bottomLeftCorner(dim, n);
    A_mm = H.bottomRightCorner(dim, dim);
    A_mm_inverse = PseudoInversePsd(A_mm);
    b_r = b.head(n);
    b_m = b.tail(dim);
  }
};

/// How rows may move, by Eigen's rows; columns do it transposed.
struct Mover {
  std::string cause;  ///< "" if it is right
  std::function<MatXX(const MatXX& A)> move;
};

// The variable changes places with its neighbour only.
inline Order WithItsNeighbour(int n, int idx, int dim) {
  Order order(n);
  std::iota(order.begin(), order.end(), 0);
  const auto begin = order.begin() + idx;
  std::rotate(begin, begin + dim, begin + dim + std::min(dim, n - idx - dim));
  return order;
}

/// `rows` is "rows", "columns" or "entries of b", for the words.
inline std::vector<Mover> Movers(const Order& order, int idx, int dim, const std::string& rows) {
  const int n = static_cast<int>(order.size()), tail = n - idx - dim;
  Order front = order, backwards = order;  // the marginalised variable first; or its rows in the other order
  std::rotate(front.begin(), front.end() - dim, front.end());
  std::reverse(backwards.end() - dim, backwards.end());
  const Order neighbour = WithItsNeighbour(n, idx, dim);
  const auto partly = [=](bool others, int own_at) {
    return [=](const MatXX& A) {
      MatXX moved = A;
      if (others) moved.middleRows(idx, tail) = A.bottomRows(tail);
      if (own_at >= 0 && own_at + dim <= n) moved.middleRows(own_at, dim) = A.middleRows(idx, dim);
      return moved;
    };
  };
  return {{"", [=](const MatXX& A) { return MoveRows(A, order); }},
          {"the " + rows + " have not moved", [](const MatXX& A) { return A; }},
          {"the variable has moved to the front; it belongs behind all others",
           [=](const MatXX& A) { return MoveRows(A, front); }},
          {"the variable has only changed places with its neighbour: what stands behind it is tail_size long",
           [=](const MatXX& A) { return MoveRows(A, neighbour); }},
          {"the variable's " + rows + " land at idx + dim instead of idx + tail_size: right for N = 3 only",
           partly(true, idx + dim)},
          {"the variable's " + rows + " are lost: they are not written to the end", partly(true, -1)},
          {"the variable's " + rows + " are read when others stand there already: take the copies",
           [=](const MatXX& A) {
             MatXX moved = A;
             moved.middleRows(idx, tail) = A.bottomRows(tail);
             moved.bottomRows(dim) = moved.middleRows(idx, dim).eval();
             return moved;
           }},
          {"the " + rows + " behind the variable have not moved up to idx", partly(false, n - dim)},
          {"the variable's " + rows + " stand at the end in reverse order",
           [=](const MatXX& A) { return MoveRows(A, backwards); }},
          {"the variable's " + rows + " are written over the first ones", partly(true, 0)}};
}

inline std::vector<Mistake> MoveMistakes(const MatXX& H, const Order& order, int idx, int dim) {
  std::vector<Mistake> mistakes{
      {"2a", "nothing has moved: neither the rows nor the columns", [=] { return H; }},
      {"2a", "the columns have moved, the rows have not", [=] { return MoveColumns(H, order); }},
      {"2b", "the rows have moved, the columns have not", [=] { return MoveRows(H, order); }}};
  for (const Mover& rows : Movers(order, idx, dim, "rows")) {
    for (const Mover& columns : Movers(order, idx, dim, "columns")) {
      const std::string cause = rows.cause.empty() ? columns.cause : rows.cause;
      if (cause.empty()) continue;
      mistakes.push_back({rows.cause.empty() ? "2b" : "2a", cause,
                          [=] { return MatXX(columns.move(rows.move(H).transpose()).transpose()); }});
    }
  }
  return mistakes;
}

inline std::vector<Mistake> MoveMistakesInB(const VecX& b, const Order& order, int idx, int dim) {
  std::vector<Mistake> mistakes{{"2a", "b has not moved with the rows of H", [=] { return b; }}};
  for (const Mover& entries : Movers(order, idx, dim, "entries of b")) {
    if (!entries.cause.empty()) mistakes.push_back({"2a", entries.cause, [=] { return entries.move(b); }});
  }
  return mistakes;
}

// The three blocks, each read at its place or at another one.
inline std::vector<Mistake> CornerMistakes(const Parts& r, int idx) {
  struct Block {
    std::string cause;  // "" if it is right
    MatXX A;
  };
  const auto n = r.A_rr.rows(), m = r.A_mm.rows();
  const MatXX& H = r.H;
  const std::string rm = "Arm is read at the wrong column: after the move it stands at the top right, column n2";
  const std::string mr = "Amr is read at the wrong row: after the move it stands at the bottom left, row n2";
  const std::string rr = "Arr is read at the wrong place: after the move it is the top left corner, from (0, 0) on";
  const auto at = std::min<Eigen::Index>(idx, n);
  std::vector<Mistake> mistakes;
  for (const Block& A_rr : {Block{"", r.A_rr}, {rr, H.bottomRightCorner(n, n)}, {rr, H.topRightCorner(n, n)}}) {
    for (const Block& A_rm : {Block{"", r.A_rm}, {rm, H.topLeftCorner(n, m)}, {rm, H.block(0, at, n, m)}}) {
      for (const Block& A_mr : {Block{"", r.A_mr}, {mr, H.topLeftCorner(m, n)}, {mr, H.block(at, 0, m, n)}}) {
        const std::string cause = !A_rr.cause.empty() ? A_rr.cause : (!A_rm.cause.empty() ? A_rm.cause : A_mr.cause);
        if (cause.empty()) continue;
        mistakes.push_back({"2c", cause, [=] { return MatXX(A_rr.A - A_rm.A * r.A_mm_inverse * A_mr.A); }});
      }
    }
  }
  return mistakes;
}

/// Corners of one size, which Eigen lets exchange.
inline std::vector<Mistake> ExchangeMistakes(const Parts& r) {
  if (r.A_rm.rows() != r.A_rm.cols()) return {};
  return {{"2c", "A_rm and A_mr are exchanged: A_rm is at the top right, rows of what remains",
           [=] { return MatXX(r.A_rr - r.A_mr * r.A_mm_inverse * r.A_rm); }},
          {"2c", "A_mr holds A_rm: it is at the bottom left, rows of what goes",
           [=] { return MatXX(r.A_rr - r.A_rm * r.A_mm_inverse * r.A_rm); }},
          {"2c", "A_rm holds A_mr: it is at the top right, rows of what remains",
           [=] { return MatXX(r.A_rr - r.A_mr * r.A_mm_inverse * r.A_mr); }},
          {"2c", "A_rr is the corner of what goes, at the bottom right; it is at the top left",
           [=] { return MatXX(r.A_mm - r.A_rm * r.A_mm_inverse * r.A_mr); }}};
}

inline std::vector<Mistake> PriorMistakes(const Parts& r, int idx) {
  std::vector<Mistake> mistakes{
      {"2d", "the sign: A_rm A_mm⁻¹ A_mr is added. What is marginalised takes information along, it brings none",
       [=] { return MatXX(r.A_rr + r.A_rm * r.A_mm_inverse * r.A_mr); }},
      {"2d",
       "A_rr alone: that fixes the variable at its value (conditioning); marginalising subtracts A_rm A_mm⁻¹ A_mr",
       [=] { return r.A_rr; }},
      {"2d", "the covariance of what remains stands here; H_prior is its inverse",
       [=] { return MatXX(PseudoInversePsd(r.H).topLeftCorner(r.A_rr.rows(), r.A_rr.cols())); }},
      {"2d", "A_mm⁻¹ is missing: tempB already holds A_rm A_mm⁻¹", [=] { return MatXX(r.A_rr - r.A_rm * r.A_mr); }},
      {"2d", "A_mm stands where its inverse is meant", [=] { return MatXX(r.A_rr - r.A_rm * r.A_mm * r.A_mr); }},
      {"2d", "the order of the difference: A_rr comes first",
       [=] { return MatXX(r.A_rm * r.A_mm_inverse * r.A_mr - r.A_rr); }},
      {"2d", "only the product A_rm A_mm⁻¹ A_mr: it is to be subtracted from A_rr",
       [=] { return MatXX(r.A_rm * r.A_mm_inverse * r.A_mr); }}};
  mistakes.push_back({"2d", "A_mm⁻¹ is a matrix: dividing by one number is right only for a variable of one row",
                      [=] { return MatXX(r.A_rr - r.A_rm * r.A_mr / r.A_mm(0, 0)); }});
  mistakes.push_back({"2d", "A_mm⁻¹ is a matrix: dividing by one number is right only for a variable of one row",
                      [=] { return MatXX(r.A_rr - r.A_rm * r.A_mr / r.A_mm.determinant()); }});
  mistakes.push_back({"2d", "A_mm⁻¹ is the inverse of the matrix, not of each entry or of the diagonal",
                      [=] { return MatXX(r.A_rr - r.A_rm * r.A_mm.cwiseInverse() * r.A_mr); }});
  mistakes.push_back({"2d", "A_mm⁻¹ is the inverse of the matrix, not of each entry or of the diagonal",
                      [=] { return MatXX(r.A_rr - r.A_rm * r.A_mm.diagonal().cwiseInverse().asDiagonal() * r.A_mr); }});
  mistakes.push_back({"2d", "A_mm⁻¹ acts twice: tempB already holds A_rm A_mm⁻¹",
                      [=] { return MatXX(r.A_rr - r.A_rm * r.A_mm_inverse * r.A_mm_inverse * r.A_mr); }});
  for (const Mistake& mistake : ExchangeMistakes(r)) mistakes.push_back(mistake);
  mistakes.push_back(
      {"2d", "the inverse is that of the wrong corner: after the move A_mm is the bottom right one", [=] {
         const auto m = r.A_mm.rows();
         return MatXX(r.A_rr - r.A_rm * PseudoInversePsd(r.H.topLeftCorner(m, m)) * r.A_mr);
       }});
  for (const Mistake& mistake : CornerMistakes(r, idx)) mistakes.push_back(mistake);
  return mistakes;
}

inline std::vector<Mistake> RightHandSideMistakes(const Parts& r, const VecX& b_given, int idx) {
  const Parts unmoved([&] {
    Parts parts = r;
    parts.b_r = b_given.head(r.b_r.size());
    parts.b_m = b_given.tail(r.b_m.size());
    return parts;
  }());
  return {
      {"2d", "b is not reduced: A_rm A_mm⁻¹ b_m is not subtracted", [=] { return r.b_r; }},
      {"2d", "the sign: A_rm A_mm⁻¹ b_m is added, not subtracted",
       [=] { return VecX(r.b_r + r.A_rm * r.A_mm_inverse * r.b_m); }},
      {"2d", "A_mm⁻¹ is missing in A_rm A_mm⁻¹ b_m", [=] { return VecX(r.b_r - r.A_rm * r.b_m); }},
      {"2d", "b_m is taken from the front of b_marg; after the move it stands at its end",
       [=] { return VecX(r.b_r - r.A_rm * r.A_mm_inverse * r.b_r.head(r.b_m.size())); }},
      {"2d", "b_m is taken at idx, where it was before the move; now it stands at the end",
       [=] { return VecX(r.b_r - r.A_rm * r.A_mm_inverse * r.b.segment(idx, r.b_m.size())); }},
      {"2d", "A_mm⁻¹ is a matrix: dividing by one number is right only for a variable of one row",
       [=] { return VecX(r.b_r - r.A_rm * r.b_m / r.A_mm(0, 0)); }},
      {"2d", "A_mm⁻¹ acts twice: tempB already holds A_rm A_mm⁻¹",
       [=] { return VecX(r.b_r - r.A_rm * r.A_mm_inverse * r.A_mm_inverse * r.b_m); }},
      {"2d", "b_r is missing: this is −A_rm A_mm⁻¹ b_m alone", [=] { return VecX(-r.A_rm * r.A_mm_inverse * r.b_m); }},
      {"2d", "b_r is missing: this is A_rm A_mm⁻¹ b_m alone", [=] { return VecX(r.A_rm * r.A_mm_inverse * r.b_m); }},
      {"2d", "b_r is read at the wrong place: after the move it is the head of b_marg",
       [=] { return VecX(r.b.tail(r.b_r.size()) - r.A_rm * r.A_mm_inverse * r.b_m); }},
      {"2d", "b_r and b_m are exchanged: b_r is the head of b_marg, b_m its tail",
       [=] { return VecX(r.b.tail(r.b_r.size()) - r.A_rm * r.A_mm_inverse * r.b.head(r.b_m.size())); }},
      {"2d", "the solution x of H_prior x = b_prior stands here; b_prior itself is meant",
       [=] {
         const MatXX H_prior = r.A_rr - r.A_rm * r.A_mm_inverse * r.A_mr;
         return VecX(PseudoInversePsd(H_prior) * (r.b_r - r.A_rm * r.A_mm_inverse * r.b_m));
       }},
      {"2a", "b_prior is made from the b before the move",
       [=] { return VecX(unmoved.b_r - r.A_rm * r.A_mm_inverse * unmoved.b_m); }}};
}

}  // namespace ch5::homework::stage_2
