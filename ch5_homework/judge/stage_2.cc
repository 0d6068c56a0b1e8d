/// Stage 2: the slides' 3×3 example, and the general case.

#include <gtest/gtest.h>

#include <array>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework {
namespace {

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

// "variable 3 of the given H"
Names VariableNames(const right::Order& order) {
  Names names;
  for (const int k : order) names.push_back({"2.variable_given_H", {{"n", Word(k)}}});
  return names;
}

// The first row, or column, that is another one of the symmetric matrix that was given.
Mistakes MovedAstray(const MatXX& given, const MatXX& got, const right::Order& order) {
  if (got.rows() != given.rows() || got.cols() != given.cols()) return {};
  MatXX sources = given;
  for (size_t k = 0; k < order.size(); ++k) sources.col(static_cast<Eigen::Index>(k)) = given.col(order[k]);
  for (const bool rows : {true, false}) {
    const MatXX is = rows ? got : got.transpose();
    for (size_t k = 0; k < order.size(); ++k) {
      const MatXX row = is.row(static_cast<Eigen::Index>(k));
      for (int other = 0; other < given.rows() && !Equal(row, sources.row(order[k]), 1e-12); ++other) {
        if (!Equal(row, sources.row(other), 1e-12)) continue;
        return {{rows ? "2a" : "2b",
                 {rows ? "2.row_is_another" : "2.column_is_another",
                  {{"i", Word(k)}, {"other", Word(other)}, {"right", Word(order[k])}}},
                 got}};
      }
    }
  }
  return {};
}

void CheckMove(const Marginalization& c, const right::Moved& right, const right::Prior& prior,
               const MarginalizeResult& got) {
  const MatXX &H = Value(right.H.right), &b = Value(right.b.right);
  const Names names = VariableNames(right.order);
  // In the columns before idx rows alone move.
  const bool rows_are_right =
      c.idx > 0 && got.H_moved.cols() >= c.idx && Equal(got.H_moved.leftCols(c.idx), H.leftCols(c.idx), 1e-12);
  const auto reduced = [](const char* it, MatXX moved, const MatXX& prior) {
    moved.topLeftCorner(prior.rows(), prior.cols()) = prior;
    return Mistakes{{"2d", {"2.changed_in_place", {{"it", Word(std::string(it))}}}, moved}};
  };
  const Mistakes in_H = reduced("H_marg", H, Value(prior.H.right)), in_b = reduced("b_marg", b, Value(prior.b.right));
  const Mistakes astray = Equal(got.H_moved, H, 1e-12) ? Mistakes() : MovedAstray(c.H, got.H_moved, right.order);
  Require({c.Of("2.H_marg_after_move"), rows_are_right ? "2b" : "2a", "H_marg", names, 1e-12, in_H, astray}, right.H,
          got.H_moved);
  Require({c.Of("2.b_marg_after_move"), "2a", "b_marg", names, 1e-12, in_b}, right.b, got.b_moved);
}

void CheckMarginalize(const MatXX& H, const VecX& b, int idx, int dim) {
  const Marginalization c{H, b, idx, dim};
  const Answer got = Ask("TestMarginalize", {{"H", H}, {"b", b}, {"idx", idx}, {"dim", dim}});
  const MarginalizeResult result{got["H_moved"], got.Vector("b_moved"), got["H_prior"], got.Vector("b_prior")};
  const right::Moved exchanged({H, b}, idx, dim, true), keeping({H, b}, idx, dim, false);
  const bool is_exchanged = Equal(result.H_moved, Value(exchanged.H.right), 1e-12);
  const right::Moved& moved = is_exchanged ? exchanged : keeping;
  const right::Prior prior({Value(moved.H.right), Value(moved.b.right)}, {H, b}, dim);
  CheckMove(c, moved, prior, result);
  const Names names = VariableNames(moved.order);
  Require({c.Of(Word("H_prior = A_rr − A_rm A_mm⁻¹ A_mr")), "2d", "H_prior", names, 1e-9}, prior.H, result.H_prior);
  Require({c.Of(Word("b_prior = b_r − A_rm A_mm⁻¹ b_m")), "2d", "b_prior", names, 1e-9}, prior.b, result.b_prior);
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
  CheckRandom(n, 3, 15);  // with its speed and biases
  Random random(Seed(28));
  MatXX H = RandomPositiveDefinite(n, &random);
  H.middleRows(9, 3) *= 1e-3;  // its angles in smaller units: their eigenvalues are small, but none is zero
  H.middleCols(9, 3) *= 1e-3;
  CheckMarginalize(H, RandomMatrix(n, 1, &random), 6, 6);
  // In units in which all numbers are small, but none is zero; the eigenvalues stay above the original's limit of 1e-8.
  const MatXX small = 1e-7 * (RandomPositiveDefinite(n, &random) + MatXX::Identity(n, n));
  CheckMarginalize(small, 1e-7 * RandomMatrix(n, 1, &random), 6, 6);
  CheckMarginalize(1e14 * small, 1e7 * RandomMatrix(n, 1, &random), 6, 6);  // and large
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
