// Slips in a formula of another course: y = A⁻¹ (b − C x).

#include <gtest/gtest.h>

#include "ch5_homework/judge/formula/slips.h"

namespace ch5::homework::formula {
namespace {

MatXX Numbers(int rows, int columns, double start) {
  MatXX A(rows, columns);
  for (int k = 0; k < A.size(); ++k) A.data()[k] = std::sin(start + 1.7 * k);
  return A;
}

// The cause that is found, as JSON, or "".
std::string CauseOf(const Formula& formula, const MatXX& got, const std::vector<Formula>& earlier = {}) {
  const auto found = FindSlip(
      formula, got, [&](const MatXX& answer) { return Equal(got, answer, 1e-9); }, earlier);
  return found ? found->cause.Json() : "";
}

struct Solved {
  MatXX big = Numbers(5, 5, 0.3), C = Numbers(3, 2, 0.9), x = Numbers(2, 1, 2.0);
  VecX b = Numbers(5, 1, 1.1);
  MatXX A;
  Formula y;

  Solved() {
    big = (big * big.transpose()).eval() + MatXX::Identity(5, 5);
    const Source whole("M", big, {{Word(std::string("M before")), 2.0 * big}}), vector("b", b);
    A = big.block(1, 1, 3, 3);
    y = {Inverse(whole.Block("A", 1, 1, 3, 3, "1a")) *
         (vector.Segment("c", 2, 3, "1b") - Matrix("C", C) * Matrix("x", x))};
  }
  MatXX c() const { return b.segment(2, 3); }
  std::string Named(const MatXX& got) const {
    const auto found = FindSlip(y, got, [&](const MatXX& answer) { return Equal(got, answer, 1e-9); });
    return found ? found->todo + " " + found->cause.Json() : "";
  }
};

TEST(Formula, HasTheValueAndTheNameOfThePage) {
  const Solved s;
  EXPECT_TRUE(Equal(Value(s.y.right), s.A.inverse() * (s.c() - s.C * s.x), 1e-9));
  EXPECT_EQ(NameOf(s.y.right), "A⁻¹ (c − C x)");
  const Expression turned = Transpose(Named(s.y.right, NameOf(s.y.right)));
  EXPECT_EQ(NameOf(turned), "(A⁻¹ (c − C x))ᵀ");
  EXPECT_EQ(NameOf(Transpose(turned)), "(A⁻¹ (c − C x))");
}

TEST(Formula, HasNoValueWhereTheSizesDoNotFit) {
  const Solved s;
  EXPECT_FALSE(TryValue(Matrix("C", s.C) * Matrix("b", s.b)));
  EXPECT_FALSE(TryValue(Matrix("C", s.C) + Matrix("x", s.x)));
  EXPECT_THROW(Value(Inverse(Matrix("C", s.C))), std::logic_error);
}

TEST(Formula, NamesOneSlip) {
  const Solved s;
  const MatXX inverse = s.A.inverse(), rest = s.c() - s.C * s.x;
  EXPECT_EQ(s.Named(inverse * (s.c() + s.C * s.x)), R"~( {"id": "formula.sign_added", "term": "C x"})~");
  EXPECT_EQ(s.Named(inverse * s.c()), R"~( {"id": "formula.nothing_subtracted", "rest": "c", "that": "C x"})~");
  EXPECT_EQ(s.Named(rest), R"~( {"id": "formula.missing_in", "this": "A⁻¹", "product": "A⁻¹ (c − C x)"})~");
  EXPECT_EQ(s.Named(s.A * rest), R"~( {"id": "formula.inverse_meant", "matrix": "A"})~");
  EXPECT_EQ(s.Named(inverse * s.c() - s.C * s.x),
            R"~( {"id": "formula.inverse_on_one_term", "inverse": "A⁻¹", "that": "c − C x"})~");
  EXPECT_EQ(s.Named(s.A.diagonal().cwiseInverse().asDiagonal() * rest),
            R"~( {"id": "formula.only_diagonal_inverted", "matrix": "A"})~");
  EXPECT_EQ(s.Named(inverse * (s.b.segment(1, 3) - s.C * s.x)),
            R"~(1b {"id": "formula.starts_at_entry", "block": "c", "matrix": "b", "i": "1", "row": "2"})~");
  EXPECT_EQ(s.Named(0.5 * inverse * rest),
            R"~(1a {"id": "formula.from_another_source", "block": "A", "other": "M before", "matrix": "M"})~");
  EXPECT_EQ(s.Named(inverse * (s.c() - 3.0 * s.C * s.x)),
            R"~( {"id": "formula.term_times", "term": "A⁻¹ C x", "k": "3"})~");
  EXPECT_EQ(s.Named(inverse * (s.c() - s.C * s.x.normalized())), R"~( {"id": "formula.normalized", "matrix": "x"})~");
  EXPECT_EQ(s.Named(inverse * (s.c() - s.C.cast<float>().cast<double>() * s.x)),
            R"~( {"id": "formula.cast_to_float", "matrix": "C"})~");
  EXPECT_EQ(s.Named(inverse * rest + s.c()),
            R"~( {"id": "formula.term_too_many", "this": "c", "that": "A⁻¹ (c − C x)"})~");
}

TEST(Formula, LooksForAnAskedCauseAlone) {
  const Solved s;
  const MatXX got = s.A.inverse() * (s.c() + s.C * s.x);
  const auto is = [&](const MatXX& answer) { return Equal(got, answer, 1e-9); };
  const auto finds = [&](const std::string& id) {
    return FindSlip(s.y, got, is, {}, [&](const Text& cause) { return cause.Json().find(id) != std::string::npos; })
        .has_value();
  };
  EXPECT_TRUE(finds("formula.sign_added"));
  EXPECT_FALSE(finds("formula.inverse_meant"));
}

// axes = [z x y] has the yaw's column in its lower triangle.
TEST(Formula, OfAMatrixThatIsNotSymmetricNobodyTakesATriangle) {
  const MatXX R = Numbers(3, 3, 0.4), axes = (MatXX(3, 3) << 0, 1, 0, 0, 0, 1, 1, 0, 0).finished();
  const MatXX lower = axes.triangularView<Eigen::Lower>();
  EXPECT_EQ(CauseOf({Matrix("R", R) * Matrix("axes", axes)}, R * lower), "");
  const MatXX symmetric = R * R.transpose(), half = symmetric.triangularView<Eigen::Lower>();
  EXPECT_EQ(CauseOf({Matrix("R", R) * Matrix("S", symmetric)}, R * half),
            R"~({"id": "formula.one_triangle_alone", "matrix": "S"})~");
}

TEST(Formula, NamesASmallMultipleOfI) {
  const Solved s;
  const MatXX rest = s.c() - s.C * s.x, I = MatXX::Identity(3, 3);
  EXPECT_EQ(s.Named((s.A + 1e-6 * I).inverse() * rest),
            R"~( {"id": "formula.multiple_of_I_added", "x": "1e-06", "matrix": "A"})~");
  EXPECT_EQ(s.Named(Value(s.y.right) * (1.0 + 1e-5)), "");  // "counts 1 times" would be no cause
}

// Q = I − U (VᵀU)⁻¹ Vᵀ: the inverse of a matrix that is not symmetric; B A⁻¹ with another inverse at another place.
TEST(Formula, NamesSlipsInProductsOfInverses) {
  const MatXX U = Numbers(4, 2, 0.2), V = Numbers(4, 2, 1.4), I = MatXX::Identity(4, 4), Vt = V.transpose();
  const Expression u = Matrix("U", U), v_t = Transpose(Matrix("V", V));
  const Formula Q{Matrix("I", I) - u * Inverse(v_t * u) * v_t};
  EXPECT_TRUE(Equal(Value(Q.right), I - U * (Vt * U).inverse() * Vt, 1e-9));
  EXPECT_EQ(CauseOf(Q, I - U * Vt * U * Vt), R"~({"id": "formula.inverse_meant", "matrix": "Vᵀ U"})~");
  EXPECT_EQ(CauseOf(Q, I - V * (U.transpose() * V).inverse() * U.transpose()),
            R"~({"id": "formula.exchanged", "this": "U", "that": "V"})~");

  const MatXX B = Numbers(2, 2, 0.6), C = Numbers(3, 2, 0.4), A = Numbers(3, 3, 0.8) + 3.0 * MatXX::Identity(3, 3);
  const Formula y{Inverse(Matrix("A", A)) * Matrix("C", C), {Matrix("B", B)}};
  EXPECT_EQ(CauseOf(y, C * B.inverse()), R"~({"id": "formula.stands_for", "this": "C B⁻¹", "that": "A⁻¹ C"})~");
}

TEST(Formula, NamesWhatIsUsedForTooMuch) {
  const MatXX J = Numbers(3, 3, 0.8), e = Numbers(3, 1, 0.1), x = Numbers(3, 1, 1.9);
  EXPECT_EQ(CauseOf({Matrix("e", e) + Matrix("J", J) * Matrix("x", x)}, J * (e + x)),
            R"~({"id": "formula.multiplies_all", "this": "J", "that": "e + J x"})~");
  MatXX D = MatXX::Zero(4, 4), first = D;
  for (int k = 0; k < 4; k += 2) D.block(k, k, 2, 2) = (k + 2.0) * MatXX::Identity(2, 2) + MatXX::Constant(2, 2, 0.3);
  const MatXX inverse = D.inverse(), B = Numbers(4, 1, 0.7);
  for (int k = 0; k < 4; k += 2) first.block(k, k, 2, 2) = inverse.block(0, 0, 2, 2);
  EXPECT_EQ(CauseOf({Inverse(Matrix("D", D), {2, 2}) * Matrix("B", B)}, first * B),
            R"~({"id": "formula.one_block_for_all", "n": "0", "matrix": "D⁻¹"})~");
}

// A variable is written once: W Mᵀ is not M Mᵀ with another M. And B c for c, both at hand.
TEST(Formula, NamesWhatStandsForAVariable) {
  const MatXX W = Numbers(3, 2, 0.8), V = Numbers(2, 2, 0.1), M = W * V;
  const Expression m = Named(Matrix("W", W) * Matrix("V", V), "M");
  EXPECT_EQ(CauseOf({m * Transpose(m)}, W * M.transpose()),
            R"~({"id": "formula.stands_for", "this": "W", "that": "M"})~");
  EXPECT_EQ(CauseOf({m * Transpose(m)}, W * W.transpose()),
            R"~({"id": "formula.missing_in", "this": "V", "product": "M"})~");
  const MatXX B = Numbers(3, 3, 0.2), c = Numbers(3, 1, 1.0), d = Numbers(3, 1, 2.0);
  EXPECT_EQ(CauseOf({Matrix("d", d) - Matrix("c", c), {Matrix("B", B)}}, d - B * c),
            R"~({"id": "formula.stands_for", "this": "B c", "that": "c"})~");
}

// A sign of what is read elsewhere may be written there too, but not where a block begins.
TEST(Formula, KnowsWhereElseASlipMayBe) {
  const Solved s;
  const auto elsewhere = [&](const MatXX& got) {
    return FindSlip(s.y, got, [&](const MatXX& answer) { return Equal(got, answer, 1e-9); })->elsewhere;
  };
  EXPECT_TRUE(elsewhere(s.A.inverse() * (s.c() + s.C * s.x)));
  EXPECT_FALSE(elsewhere(s.A.inverse() * (s.b.segment(1, 3) - s.C * s.x)));
  EXPECT_FALSE(elsewhere(s.c() - s.C * s.x));
}

TEST(Formula, CountsTheTermsOfAPart) {
  const MatXX a = Numbers(2, 1, 0.5), b = Numbers(3, 1, 1.0), c = Numbers(3, 1, 2.0);
  const MatXX got = (MatXX(5, 1) << a, b - 0.5 * c).finished();
  EXPECT_EQ(CauseOf({Stack({Matrix("a", a), Matrix("b", b) - Matrix("c", c)})}, got),
            R"~({"id": "formula.term_times", "term": "c", "k": "0.5"})~");
}

TEST(Formula, NamesNothingElse) {
  const Solved s;
  EXPECT_EQ(s.Named(Value(s.y.right) + 1e-3 * Numbers(3, 1, 7.0)), "");
  EXPECT_EQ(s.Named(Numbers(3, 1, 8.0)), "");
}

// Copies side by side, one of them over what another has written; and a part of the first call's formula in the second's.
TEST(Formula, NamesWhatLandsElsewhereOrStays) {
  const Source whole("M", Numbers(4, 4, 0.3));
  const Formula copied{
      Assembly("H", 6, 6, {{whole.Block("A", 0, 0, 2, 2), {0, 0}}, {whole.Block("B", 0, 2, 2, 2), {0, 4}}})};
  MatXX got = MatXX::Zero(6, 6);
  got.topLeftCorner(2, 2) = Numbers(4, 4, 0.3).topLeftCorner(2, 2);
  got.block(0, 1, 2, 2) = Numbers(4, 4, 0.3).topRightCorner(2, 2);
  EXPECT_EQ(CauseOf(copied, got),
            R"~({"id": "formula.lies_at", "block": "B", "i": "0", "j": "1", "row": "0", "column": "4"})~");

  const auto product = [](double call) {
    return Formula{Matrix("A", Numbers(3, 3, call)) * Matrix("x", Numbers(3, 1, 2.0 * call))};
  };
  const Formula first = product(1.0), second = product(2.0);
  const MatXX kept = Numbers(3, 3, 1.0) * Numbers(3, 1, 4.0);
  EXPECT_EQ(CauseOf(second, kept), "");
  EXPECT_EQ(CauseOf(second, kept, {first}), R"~({"id": "formula.kept_from_the_first", "this": "A"})~");
  const Formula smaller{Matrix("A", Numbers(2, 2, 1.0)) * Matrix("x", Numbers(2, 1, 1.0))};
  EXPECT_EQ(CauseOf(second, kept, {smaller, first}), CauseOf(second, kept, {first}));
}

// The signs of x are lost where they are negative: an earlier call, in which that sign was right, refutes the term's.
TEST(Formula, NamesNoSlipThatAnEarlierCallRefutes) {
  const auto sum = [](double x) {
    return Formula{Matrix("a", Numbers(2, 1, 3.0)) -
                   Matrix("B", Numbers(2, 1, 1.0)) * Matrix("x", MatXX::Constant(1, 1, x))};
  };
  const Formula earlier = sum(2.0), now = sum(-2.0);
  const MatXX got = Numbers(2, 1, 3.0) - 2.0 * Numbers(2, 1, 1.0);
  EXPECT_NE(CauseOf(now, got).find("formula.sign_"), std::string::npos);
  EXPECT_NE(CauseOf(now, got, {earlier}).find("formula.signs_lost"), std::string::npos);
}

// Two edges add JᵀJ of their own; what one statement of the loop does, it does for both.
TEST(Formula, NamesASlipInALoop) {
  std::vector<Share> shares;
  std::vector<MatXX> J;
  for (int edge = 0; edge < 2; ++edge) {
    J.push_back(Numbers(2, 2, 0.4 + edge));
    const Expression factor = Matrix("J", J.back()), W = Matrix("W", (edge + 2.0) * MatXX::Identity(2, 2));
    shares.push_back({Transpose(factor) * W * factor, {edge, edge}, {}, {edge == 0 ? "a.first" : "a.last"}});
  }
  const Formula H{Assembly("H", 3, 3, shares)};
  const auto assembled = [&](double first, double last) {
    MatXX A = MatXX::Zero(3, 3);
    A.topLeftCorner(2, 2) += first * J[0].transpose() * J[0];
    A.bottomRightCorner(2, 2) += last * J[1].transpose() * J[1];
    return A;
  };
  EXPECT_TRUE(Equal(Value(H.right), assembled(2.0, 3.0), 1e-12));
  EXPECT_EQ(CauseOf(H, assembled(1.0, 1.0)), R"~({"id": "formula.missing_in", "this": "W", "product": "Jᵀ W J"})~");
  EXPECT_EQ(CauseOf(H, assembled(0.0, 3.0)),
            R"~({"id": "formula.shares_missing", "kind": {"id": "a.first"}, "matrix": "H"})~");

  // J of the first turn in every turn; a block that loses its signs, or lands a row too far.
  MatXX kept = assembled(2.0, 0.0), unsigned_ones = kept, shifted = kept;
  kept.bottomRightCorner(2, 2) += 3.0 * J[0].transpose() * J[0];
  EXPECT_EQ(CauseOf(H, kept), R"~({"id": "formula.kept_from_the_first", "this": "J"})~");
  unsigned_ones.bottomRightCorner(2, 2) += 3.0 * J[1].cwiseAbs().transpose() * J[1].cwiseAbs();
  EXPECT_EQ(
      CauseOf(H, unsigned_ones),
      R"~({"id": "formula.in_kind", "kind": {"id": "a.last"}, "cause": {"id": "formula.signs_lost", "matrix": "J"}})~");
  shifted.topRightCorner(2, 2) += 3.0 * J[1].transpose() * J[1];
  EXPECT_EQ(CauseOf(H, shifted), R"~({"id": "formula.one_row_off", "kind": {"id": "a.last"}})~");

  MatXX twice = Value(H.right);
  twice.topRightCorner(2, 2) += Value(shares[0].x);
  EXPECT_EQ(CauseOf(H, twice), R"~({"id": "formula.stands_there_too", "this": "Jᵀ W J", "i": "0", "j": "1"})~");

  for (size_t k = 0; k < 3; ++k) {
    if (k == 2) shares.push_back({Matrix("more", Numbers(3, 3, 0.2)), {0, 0}});
    shares[k].kinds.clear();
    shares[k].turns = {{"a.loop", k, 3}};
  }
  const Formula in_turns{Assembly("H", 3, 3, shares)};
  const auto turn = [&](size_t k) { return Value(Assembly("H", 3, 3, {shares[k]})); };
  for (const auto& [id, got] : {std::pair<const char*, MatXX>{"formula.loop_ends_at_once", turn(0)},
                                {"formula.loop_begins_late", turn(1) + turn(2)},
                                {"formula.loop_ends_early", turn(0) + turn(1)},
                                {"formula.loop_keeps_last", turn(2)}}) {
    EXPECT_EQ(CauseOf(in_turns, got), std::string(R"({"id": ")") + id + R"(", "loop": {"id": "a.loop"}})");
  }
}

}  // namespace
}  // namespace ch5::homework::formula
