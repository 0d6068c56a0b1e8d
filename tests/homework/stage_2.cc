/// Stage 2: the slides' 3×3 example with its printed numbers, and the general case.

#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "ch5_backend/math/psd.h"
#include "tests/homework/narrate.h"
#include "tests/homework/scenes.h"
#include "tests/homework/submission.h"

namespace ch5::homework {
namespace {

using Order = std::vector<int>;  // Order[k] = the former place of the variable that stands at k

// The order that is asked: the others keep theirs, the marginalised variable goes behind them.
Order KeepingOrder(int n, int idx, int dim) {
  Order order;
  for (int k = 0; k < n; ++k) {
    if (k < idx || k >= idx + dim) order.push_back(k);
  }
  for (int k = idx; k < idx + dim; ++k) order.push_back(k);
  return order;
}

// Accepted too: the variable changes places with the last ones.
Order Exchanging(int n, int idx, int dim) {
  Order order(n);
  std::iota(order.begin(), order.end(), 0);
  for (int k = dim - 1; k >= 0; --k) std::swap(order[idx + k], order[n - dim + k]);
  return order;
}

MatXX MoveRows(const MatXX& A, const Order& order) {
  MatXX moved(A.rows(), A.cols());
  for (size_t k = 0; k < order.size(); ++k) moved.row(static_cast<int>(k)) = A.row(order[k]);
  return moved;
}
MatXX MoveColumns(const MatXX& A, const Order& order) { return MoveRows(A.transpose(), order).transpose(); }
MatXX Move(const MatXX& H, const Order& order) { return MoveColumns(MoveRows(H, order), order); }

Names VariableNames(const Order& order) {
  Names names;
  for (const int k : order) names.push_back("variable " + std::to_string(k) + " of the given H");
  return names;
}

/// H and b, moved and taken apart: r remains, m goes.
struct Parts {
  MatXX A_rr, A_rm, A_mr, A_mm, A_mm_inverse;
  VecX b_r, b_m;

  Parts(const MatXX& H, const VecX& b, int dim) {
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

// A move whose second block lands at idx + dim in place of idx + tail: right for N = 3 and the middle only.
MatXX MoveRowsAsForThree(const MatXX& A, int idx, int dim) {
  const int tail = static_cast<int>(A.rows()) - idx - dim;
  MatXX moved = A;
  moved.middleRows(idx, tail) = A.bottomRows(tail);
  if (tail >= dim) moved.middleRows(idx + dim, dim) = A.middleRows(idx, dim);  // else it would not fit
  return moved;
}
MatXX MoveColumnsAsForThree(const MatXX& A, int idx, int dim) {
  return MoveRowsAsForThree(A.transpose(), idx, dim).transpose();
}

// The variable changes places with its neighbour only.
Order WithItsNeighbour(int n, int idx, int dim) {
  Order order(n);
  std::iota(order.begin(), order.end(), 0);
  const auto begin = order.begin() + idx;
  std::rotate(begin, begin + dim, begin + dim + std::min(dim, n - idx - dim));
  return order;
}

std::vector<Mistake> MoveMistakes(const MatXX& H, const Order& order, int idx, int dim) {
  Order front = order;  // the marginalised variable first
  std::rotate(front.begin(), front.end() - dim, front.end());
  const Order neighbour = WithItsNeighbour(static_cast<int>(H.rows()), idx, dim);
  const std::string too_near = " lands at idx + dim instead of idx + tail_size: right for N = 3 only";
  return {{"2a", "nothing has moved: neither the rows nor the columns", [=] { return H; }},
          {"2a", "the columns have moved, the rows have not", [=] { return MoveColumns(H, order); }},
          {"2b", "the rows have moved, the columns have not", [=] { return MoveRows(H, order); }},
          {"2a", "the variable has moved to the front; it belongs behind all others", [=] { return Move(H, front); }},
          {"2a", "the variable has only changed places with its neighbour: what stands behind it is tail_size long",
           [=] { return Move(H, neighbour); }},
          {"2a", "the variable's own part" + too_near,
           [=] { return MoveColumnsAsForThree(MoveRowsAsForThree(H, idx, dim), idx, dim); }},
          {"2a", "the block of the variable's rows" + too_near,
           [=] { return MoveColumns(MoveRowsAsForThree(H, idx, dim), order); }},
          {"2b", "the block of the variable's columns" + too_near,
           [=] { return MoveColumnsAsForThree(MoveRows(H, order), idx, dim); }}};
}

std::vector<Mistake> PriorMistakes(const Parts& r) {
  std::vector<Mistake> mistakes{
      {"2d", "the sign: A_rm A_mm⁻¹ A_mr is added. What is marginalised takes information along, it brings none",
       [=] { return MatXX(r.A_rr + r.A_rm * r.A_mm_inverse * r.A_mr); }},
      {"2d",
       "A_rr alone: that fixes the variable at its value (conditioning); marginalising subtracts A_rm A_mm⁻¹ A_mr",
       [=] { return r.A_rr; }},
      {"2d", "A_mm⁻¹ is missing: tempB already holds A_rm A_mm⁻¹", [=] { return MatXX(r.A_rr - r.A_rm * r.A_mr); }},
      {"2d", "A_mm stands where its inverse is meant", [=] { return MatXX(r.A_rr - r.A_rm * r.A_mm * r.A_mr); }},
      {"2d", "the order of the difference: A_rr comes first",
       [=] { return MatXX(r.A_rm * r.A_mm_inverse * r.A_mr - r.A_rr); }},
      {"2d", "only the product A_rm A_mm⁻¹ A_mr: it is to be subtracted from A_rr",
       [=] { return MatXX(r.A_rm * r.A_mm_inverse * r.A_mr); }}};
  if (r.A_rm.rows() == r.A_rm.cols()) {
    mistakes.push_back({"2c", "A_rm and A_mr are exchanged: A_rm is at the top right, rows of what remains",
                        [=] { return MatXX(r.A_rr - r.A_mr * r.A_mm_inverse * r.A_rm); }});
    mistakes.push_back({"2c", "A_mr holds A_rm: it is at the bottom left, rows of what goes",
                        [=] { return MatXX(r.A_rr - r.A_rm * r.A_mm_inverse * r.A_rm); }});
    mistakes.push_back({"2c", "A_rm holds A_mr: it is at the top right, rows of what remains",
                        [=] { return MatXX(r.A_rr - r.A_mr * r.A_mm_inverse * r.A_mr); }});
    mistakes.push_back({"2c", "A_rr is the corner of what goes, at the bottom right; it is at the top left",
                        [=] { return MatXX(r.A_mm - r.A_rm * r.A_mm_inverse * r.A_mr); }});
  }
  return mistakes;
}

std::vector<Mistake> RightHandSideMistakes(const Parts& r, const VecX& b_given) {
  const Parts unmoved([&] {
    Parts parts = r;
    parts.b_r = b_given.head(r.b_r.size());
    parts.b_m = b_given.tail(r.b_m.size());
    return parts;
  }());
  return {{"2d", "b is not reduced: A_rm A_mm⁻¹ b_m is not subtracted", [=] { return r.b_r; }},
          {"2d", "the sign: A_rm A_mm⁻¹ b_m is added, not subtracted",
           [=] { return VecX(r.b_r + r.A_rm * r.A_mm_inverse * r.b_m); }},
          {"2d", "A_mm⁻¹ is missing in A_rm A_mm⁻¹ b_m", [=] { return VecX(r.b_r - r.A_rm * r.b_m); }},
          {"2d", "b_m is taken from the front of b_marg; after the move it stands at its end",
           [=] { return VecX(r.b_r - r.A_rm * r.A_mm_inverse * r.b_r.head(r.b_m.size())); }},
          {"2a", "b_prior is made from the b before the move",
           [=] { return VecX(unmoved.b_r - r.A_rm * r.A_mm_inverse * unmoved.b_m); }}};
}

void CheckMarginalize(const MatXX& H, const VecX& b, int idx, int dim) {
  const int n = static_cast<int>(H.rows());
  const MarginalizeResult result = Chosen().test_marginalize(H, b, idx, dim);
  const std::string where = ", marginalising " +
                            (dim == 1 ? "variable " + std::to_string(idx)
                                      : "variables " + std::to_string(idx) + " to " + std::to_string(idx + dim - 1)) +
                            " of " + std::to_string(n);

  Order order = KeepingOrder(n, idx, dim);
  const Order exchanged = Exchanging(n, idx, dim);
  if (Equal(result.H_moved, Move(H, exchanged), 1e-12)) order = exchanged;
  const Names names = VariableNames(order);
  ASSERT_NO_STORY({"2",
                   "H_marg after the move (the others keep their order; exchanging with the last is fine too)" + where,
                   Move(H, order), result.H_moved, names, MoveMistakes(H, order, idx, dim), 1e-12});
  ASSERT_NO_STORY({"2",
                   "b_marg after the move" + where,
                   MoveRows(b, order),
                   result.b_moved,
                   names,
                   {{"2a", "b has not moved with the rows of H", [&] { return b; }}},
                   1e-12});

  const Parts right(Move(H, order), MoveRows(b, order), dim);
  ASSERT_NO_STORY({"2", "H_prior = A_rr − A_rm A_mm⁻¹ A_mr" + where,
                   right.A_rr - right.A_rm * right.A_mm_inverse * right.A_mr, result.H_prior, names,
                   PriorMistakes(right), 1e-9});
  ASSERT_NO_STORY({"2", "b_prior = b_r − A_rm A_mm⁻¹ b_m" + where,
                   right.b_r - right.A_rm * right.A_mm_inverse * right.b_m, result.b_prior, names,
                   RightHandSideMistakes(right, b), 1e-9});
}

void CheckRandom(int n, int idx, int dim) {
  Random random(Seed(100 * n + 10 * idx + dim));
  const MatXX H = RandomPositiveDefinite(n, &random);
  CheckMarginalize(H, RandomMatrix(n, 1, &random), idx, dim);
}

TEST(Stage2, TheSlidesExample) {
  MatXX H(3, 3);
  H << 100, -100, 0, -100, 100 + 100 / 9.0 + 25, -100 / 9.0, 0, -100 / 9.0, 100 / 9.0;
  CheckMarginalize(H, VecX::Zero(3), 1, 1);
  if (HasFatalFailure()) return;
  // The numbers that the slides print.
  const MarginalizeResult result = Chosen().test_marginalize(H, VecX::Zero(3), 1, 1);
  EXPECT_NEAR(result.H_moved(2, 2), 136.111, 1e-3);
  EXPECT_NEAR(result.H_moved(1, 2), -11.1111, 1e-4);
  EXPECT_NEAR(result.H_prior(0, 0), 26.5306, 1e-4);
  EXPECT_NEAR(result.H_prior(0, 1), -8.16327, 1e-5);
  EXPECT_NEAR(result.H_prior(1, 0), -8.16327, 1e-5);
  EXPECT_NEAR(result.H_prior(1, 1), 10.2041, 1e-4);
}

TEST(Stage2, FirstMiddleAndLastVariable) {
  const int n = Vary(5, 9, 24);
  for (const int idx : {1, 0, 3, n - 1}) {
    CheckRandom(n, idx, 1);
    if (HasFatalFailure()) return;
  }
}

TEST(Stage2, SeveralRowsAtOnce) {
  for (const auto& [n, idx, dim] : {std::array{4, 1, 2}, {4, 0, 2}, {8, 0, 3}, {8, 1, 3}, {8, 4, 3}, {8, 5, 3}}) {
    CheckRandom(n, idx, dim);
    if (HasFatalFailure()) return;
  }
}

TEST(Stage2, APoseOutOfAWindow) {
  const int n = Vary(20, 30, 25);
  CheckRandom(n, 6, 6);
  if (HasFatalFailure()) return;
  CheckRandom(n, 0, 6);
}

}  // namespace
}  // namespace ch5::homework
