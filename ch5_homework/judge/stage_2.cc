/// Stage 2: the slides' 3×3 example, and the general case.

#include <gtest/gtest.h>

#include <array>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/mistakes/stage_2.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework {
namespace {

using namespace stage_2;

/// Variables idx … idx + dim − 1 leave H x = b.
struct Marginalization {
  MatXX H;
  VecX b;
  int idx, dim;

  /// "H_marg after the move, marginalizing variables 3 to 5 of 8".
  Text Of(const Text& quantity) const {
    if (dim == 1) return {"2.of_one_variable", {{"quantity", quantity}, {"k", Word(idx)}, {"n", Word(n())}}};
    return {"2.of_variables", {{"quantity", quantity}, {"k", Word(idx)}, {"l", Word(idx + dim - 1)}, {"n", Word(n())}}};
  }
  int n() const { return static_cast<int>(H.rows()); }
};

void CheckMove(const Marginalization& c, const Order& order, const MarginalizeResult& result) {
  const System right{Move(c.H, order), MoveRows(c.b, order)};
  const right::Prior prior(right, {c.H, c.b}, c.dim);
  // In the columns before idx rows alone move.
  const bool rows_are_right = c.idx > 0 && result.H_moved.cols() >= c.idx &&
                              Equal(result.H_moved.leftCols(c.idx), right.H.leftCols(c.idx), 1e-12);
  Require(
      "2", c.Of("2.H_marg_after_move"), right.H, result.H_moved, VariableNames(order),
      [&] {
        std::vector<Mistake> mistakes = MoveMistakes(c.H, order, c.idx, c.dim);
        mistakes.push_back({"2d", {"2.changed_in_place", {{"it", Word("H_marg")}}}, right.H});
        mistakes.back().answer.topLeftCorner(order.size() - c.dim, order.size() - c.dim) = Value(prior.H.right);
        return mistakes;
      },
      1e-12, rows_are_right ? "2b" : "2a", "H_marg");
  Require(
      "2", c.Of("2.b_marg_after_move"), right.b, result.b_moved, VariableNames(order),
      [&] {
        std::vector<Mistake> mistakes = MoveMistakesInB(c.b, order, c.idx, c.dim);
        mistakes.push_back({"2d", {"2.changed_in_place", {{"it", Word("b_marg")}}}, right.b});
        mistakes.back().answer.topRows(order.size() - c.dim) = Value(prior.b.right);
        return mistakes;
      },
      1e-12, "2a", "b_marg");
}

void CheckPrior(const Marginalization& c, const Order& order, const MarginalizeResult& result) {
  const right::Prior right({Move(c.H, order), MoveRows(c.b, order)}, {c.H, c.b}, c.dim);
  Require({"2", c.Of(Word("H_prior = A_rr − A_rm A_mm⁻¹ A_mr")), "2d", "H_prior", VariableNames(order), {}, 1e-9},
          right.H, result.H_prior);
  Require({"2", c.Of(Word("b_prior = b_r − A_rm A_mm⁻¹ b_m")), "2d", "b_prior", VariableNames(order), {}, 1e-9},
          right.b, result.b_prior);
}

void CheckMarginalize(const MatXX& H, const VecX& b, int idx, int dim) {
  const Marginalization c{H, b, idx, dim};
  const Answer got = Ask("TestMarginalize", {{"H", H}, {"b", b}, {"idx", idx}, {"dim", dim}});
  const MarginalizeResult result{got["H_moved"], got.Vector("b_moved"), got["H_prior"], got.Vector("b_prior")};
  const int n = static_cast<int>(H.rows());
  const Order exchanged = Exchanging(n, idx, dim);
  const Order order = Equal(result.H_moved, Move(H, exchanged), 1e-12) ? exchanged : KeepingOrder(n, idx, dim);
  CheckMove(c, order, result);
  CheckPrior(c, order, result);
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
}

TEST(Stage2, FirstMiddleAndLastVariable) {
  const int n = Vary(5, 9, 24);
  for (const int idx : {1, 0, 3, n - 1}) CheckRandom(n, idx, 1);
}

TEST(Stage2, SeveralRowsAtOnce) {
  for (const auto& [n, idx, dim] :
       {std::array{5, 1, 2}, {4, 1, 2}, {4, 0, 2}, {8, 0, 3}, {8, 1, 3}, {8, 4, 3}, {8, 5, 3}}) {
    CheckRandom(n, idx, dim);
  }
}

TEST(Stage2, APoseOutOfAWindow) {
  const int n = Vary(20, 30, 25);
  CheckRandom(n, 6, 6);
  CheckRandom(n, 0, 6);
  Random random(Seed(28));
  MatXX H = RandomPositiveDefinite(n, &random);
  H.middleRows(9, 3) *= 1e-3;  // its angles in smaller units: their eigenvalues are small, but none is zero
  H.middleCols(9, 3) *= 1e-3;
  CheckMarginalize(H, RandomMatrix(n, 1, &random), 6, 6);
}

// What leaves was not measured in all its directions: nothing has measured its last component, or only the difference of
// its first two. The zeros are exact, so that an inverse in place of the pseudo-inverse is not finite.
TEST(Stage2, AVariableThatIsNotFullyMeasured) {
  const int n = Vary(7, 10, 26), idx = 2, dim = 3;
  for (const bool only_difference : {false, true}) {
    Random random(Seed(27 + only_difference));
    MatXX H = RandomPositiveDefinite(n, &random);
    VecX b = RandomMatrix(n, 1, &random);
    const int k = only_difference ? idx + 1 : idx + dim - 1;
    const double sign = only_difference ? -1.0 : 0.0;  // of row k beside the variable's first
    H.col(k) = sign * H.col(idx);
    H.row(k) = sign * H.row(idx);
    b[k] = sign * b[idx];
    CheckMarginalize(H, b, idx, dim);
  }
}

}  // namespace
}  // namespace ch5::homework
