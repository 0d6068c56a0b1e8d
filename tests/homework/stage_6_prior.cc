/// Stage 6, TODOs 6d to 6f: from A and b to a prior, each function on numbers of its own, then all of 6a to 6f together.
/// stage_6.cc comes before, stage_6_drop_sets.cc goes on.

#include <gtest/gtest.h>

#include "ch5_backend/marginalize/square_root.h"
#include "tests/homework/narrate.h"
#include "tests/homework/stage_6_scene.h"
#include "tests/homework/submission.h"

namespace ch5::homework {
namespace {

// ---- 6d SchurComplement -------------------------------------------------------------------------------------------

/// A and b with the dropped rows first, and what typical mistakes make of them.
struct SchurCase {
  MatXX A;
  VecX b;
  int m;
  MatXX mm_pinv;

  SchurCase(const MatXX& A_given, const VecX& b_given, int dropped) : A(A_given), b(b_given), m(dropped) {
    mm_pinv = Pinv(1e-8);
  }
  int n() const { return static_cast<int>(A.rows()) - m; }
  MatXX Pinv(double eps) const {
    const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
    const VecX S = (mm.S.array() > eps).select(mm.S.cwiseInverse(), 0.0);
    return mm.V * S.asDiagonal() * mm.V.transpose();
  }
  MatXX Schur(const MatXX& middle, double sign = -1.0) const {
    return A.bottomRightCorner(n(), n()) + sign * A.bottomLeftCorner(n(), m) * middle * A.topRightCorner(m, n());
  }
  VecX Reduced(const MatXX& middle, double sign = -1.0) const {
    return b.tail(n()) + sign * A.bottomLeftCorner(n(), m) * (middle * b.head(m));
  }
  std::vector<Mistake> Mistakes() const {
    const MatXX A_mm = A.topLeftCorner(m, m), A_rm = A.bottomLeftCorner(n(), m);
    return {
        {"6d", "nothing is subtracted: this is A_rr", [this] { return MatXX(A.bottomRightCorner(n(), n())); }},
        {"6d", "the sign: A_rm A_mm⁺ A_mr is added, not subtracted", [this] { return Schur(mm_pinv, 1.0); }},
        {"6d", "A_mm stands where A_mm⁺ is meant", [=] { return Schur(A_mm); }},
        {"6d", "A_mm⁺ is missing: this is A_rr − A_rm A_mr", [this] { return Schur(MatXX::Identity(m, m)); }},
        {"6d", "the eigenvalues up to kEps were inverted too: their S⁺ is 0", [this] { return Schur(Pinv(1e-300)); }},
        {"6d", "the eigenvalues above kEps were set to 0, not those up to it",
         [=] { return Schur(Pinv(1e-300) - mm_pinv); }},
        {"6d", "the roots of 1/S stand in A_mm⁺: there S⁺ is 1/S itself",
         [this] {
           const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
           const VecX root = (mm.S.array() > 1e-8).select(mm.S.cwiseInverse().cwiseAbs().cwiseSqrt(), 0.0);
           return Schur(mm.V * root.asDiagonal() * mm.V.transpose());
         }},
        {"6d", "Vᵀ S⁺ V instead of V S⁺ Vᵀ",
         [this] {
           const SymmetricEigen mm = DecomposeSymmetric(A.topLeftCorner(m, m));
           const VecX S = (mm.S.array() > 1e-8).select(mm.S.cwiseInverse(), 0.0);
           return Schur(mm.V.transpose() * S.asDiagonal() * mm.V);
         }},
        {"6d", "the corners are exchanged: the dropped rows stand first, A_rr is the lower right corner", [this] {
           if (n() != m) return MatXX(MatXX::Zero(n(), n()));
           return MatXX(A.topLeftCorner(n(), n()) - A.topRightCorner(n(), n()) *
                                                        A.bottomRightCorner(n(), n()).inverse() *
                                                        A.bottomLeftCorner(n(), n()));
         }}};
  }
  std::vector<Mistake> MistakesInB() const {
    return {{"6d", "b is not reduced: this is b_r", [this] { return VecX(b.tail(n())); }},
            {"6d", "the sign: A_rm A_mm⁺ b_m is added, not subtracted", [this] { return Reduced(mm_pinv, 1.0); }},
            {"6d", "A_mm⁺ is missing: this is b_r − A_rm b_m", [this] { return Reduced(MatXX::Identity(m, m)); }},
            {"6d", "b_m is missing, its place holds b_r",
             [this] {
               return n() == m ? VecX(b.tail(n()) - A.bottomLeftCorner(n(), m) * mm_pinv * b.tail(n())) : VecX(b);
             }},
            {"6d", "head and tail of b_ are exchanged: b_m stands first", [this] {
               return n() == m ? VecX(b.head(n()) - A.bottomLeftCorner(n(), m) * mm_pinv * b.tail(m)) : VecX(b);
             }}};
  }
};

void CheckSchur(const SchurCase& c, const std::string& what) {
  const auto term = Chosen().make_vins_term();
  const VinsTerm::Members inside = term->Inside();
  *inside.A = c.A;
  *inside.b = c.b;
  *inside.m = c.m;
  *inside.n = c.n();
  const VinsTerm::KeptSystem got = term->SchurComplement();
  ASSERT_NO_STORY({"6", "A_r " + what, c.Schur(c.mm_pinv), got.A, {}, c.Mistakes(), 1e-8});
  ASSERT_NO_STORY({"6", "b_r " + what, c.Reduced(c.mm_pinv), got.b, {}, c.MistakesInB(), 1e-8});
}

TEST(Stage6, SchurComplementOfTheDroppedRows) {
  Random random(Seed(61));
  for (const auto& [m, n] :
       {std::pair{6, 6}, std::pair{Vary(9, 15, 65), 6}, std::pair{1, 6}, std::pair{21, Vary(12, 18, 66)}}) {
    const SchurCase c(RandomPositiveDefinite(m + n, &random), RandomMatrix(m + n, 1, &random), m);
    CheckSchur(c, "where " + std::to_string(m) + " rows go and " + std::to_string(n) + " stay");
    if (HasFatalFailure()) return;
  }
}

// Depths without information: one of exactly none, one of 1e-10, which is what is left of a few roundings.
TEST(Stage6, SchurComplementWithUnknownDepths) {
  Random random(Seed(62));
  const int m = 8, n = 6;
  MatXX J = RandomMatrix(20, m + n, &random);
  J.col(0).setZero();
  J.col(1).setZero();
  J(0, 1) = 1e-5;
  const MatXX A = J.transpose() * J;
  CheckSchur(SchurCase(A, J.transpose() * RandomMatrix(20, 1, &random), m), "with two unknown depths");
}

// ---- 6e Factor ----------------------------------------------------------------------------------------------------

struct FactorCase {
  MatXX A;
  VecX b;
  MatXX V, S, S_pinv, S_uncut;  // A_r = V S Vᵀ, diagonal matrices

  FactorCase(const MatXX& A_given, const VecX& b_given) : A(A_given), b(b_given) {
    const SymmetricEigen eigen = DecomposeSymmetric(A);
    const auto known = eigen.S.array() > 1e-8;
    V = eigen.V;
    S = VecX(known.select(eigen.S, 0.0)).asDiagonal();
    S_pinv = VecX(known.select(eigen.S.cwiseInverse(), 0.0)).asDiagonal();
    S_uncut = VecX(eigen.S.cwiseMax(0.0)).asDiagonal();
  }
  static MatXX Root(const MatXX& diagonal) { return diagonal.cwiseSqrt(); }
  MatXX RightJ() const { return Root(S) * V.transpose(); }

  std::vector<Mistake> Mistakes() const {
    const auto gram = [](const MatXX& J) { return [J] { return MatXX(J.transpose() * J); }; };
    return {{"6e", "V stands where Vᵀ is meant: J = S^½ Vᵀ", gram(Root(S) * V)},
            {"6e", "J is transposed: this is V S^½", gram(V * Root(S))},
            {"6e", "S stands where its root is meant", gram(S * V.transpose())},
            {"6e", "S^½ is missing: J = S^½ Vᵀ", gram(V.transpose())},
            {"6e", "S^-½ stands where S^½ is meant", gram(Root(S_pinv) * V.transpose())},
            {"6e", "eigenvalues up to kEps count in J: there S^½ is 0", gram(Root(S_uncut) * V.transpose())},
            {"6e", "J is A_r itself", gram(A)}};
  }
  /// As answers of Jᵀr₀.
  std::vector<Mistake> MistakesInR0() const {
    const MatXX Jt = RightJ().transpose();
    const auto r0 = [=](const MatXX& r) { return [Jt, r] { return MatXX(Jt * r); }; };
    return {{"6e", "the sign: VINS' b is +JᵀWr, so r₀ = +S^-½ Vᵀ b_r", r0(-Root(S_pinv) * V.transpose() * b)},
            {"6e", "r₀ is zero: it was not set", r0(VecX::Zero(b.size()))},
            {"6e", "r₀ is b_r itself", r0(b)},
            {"6e", "S^-½ is missing: this is Vᵀ b_r", r0(V.transpose() * b)},
            {"6e", "S^½ stands where S^-½ is meant", r0(Root(S) * V.transpose() * b)},
            {"6e", "1/S stands where its root is meant", r0(S_pinv * V.transpose() * b)},
            {"6e", "V stands where Vᵀ is meant: r₀ = S^-½ Vᵀ b_r", r0(Root(S_pinv) * V * b)}};
  }
};

void CheckFactor(const FactorCase& c, const std::string& what) {
  const auto term = Chosen().make_vins_term();
  term->Factor({c.A, c.b});
  const MatXX& J = *term->Inside().J;
  const VecX& r0 = *term->Inside().r0;
  if (J.cols() != c.A.rows() || r0.size() != J.rows()) {
    FAIL() << Story(
        "6", "the sizes of J and r₀ " + what,
        "J with " + std::to_string(c.A.rows()) + " columns, r₀ with a row for each row of J",
        "J " + std::to_string(J.rows()) + "×" + std::to_string(J.cols()) + ", r₀ " + std::to_string(r0.size()),
        J.size() == 0 ? "linearized_jacobians_ was not set" : "r₀ belongs to the rows of J", "6e");
  }
  ASSERT_NO_STORY({"6",
                   "JᵀJ " + what + ", which must be A_r",
                   c.V * c.S * c.V.transpose(),
                   J.transpose() * J,
                   {},
                   c.Mistakes(),
                   1e-9});
  if (!r0.allFinite()) {
    FAIL() << Story("6", "r₀ " + what, "finite numbers", "infinite ones",
                    "an eigenvalue of zero was divided by: where S ≤ kEps, S^-½ is 0", "6e");
  }
  const VecX right = c.V * (c.S * c.S_pinv) * c.V.transpose() * c.b;  // b_r in the range of A_r
  ASSERT_NO_STORY({"6", "Jᵀr₀ " + what + ", which must be b_r", right, J.transpose() * r0, {}, c.MistakesInR0(), 1e-8});
  const double cost = c.b.dot(c.V * c.S_pinv * c.V.transpose() * c.b);
  if (std::abs(r0.squaredNorm() - cost) > 1e-8 * cost) {
    FAIL() << Story("6", "r₀ᵀr₀ " + what, std::to_string(cost), std::to_string(r0.squaredNorm()),
                    "eigenvalues up to kEps count in r₀: there S^-½ is 0", "6e");
  }
}

TEST(Stage6, FactorsARegularSystem) {
  Random random(Seed(63));
  CheckFactor({RandomPositiveDefinite(6, &random), RandomMatrix(6, 1, &random)}, "of 6 rows");
}

TEST(Stage6, FactorsASystemWithFreeDirections) {  // position and yaw: four eigenvalues are zero
  Random random(Seed(64));
  const MatXX B = RandomMatrix(8, 12, &random);
  CheckFactor({B.transpose() * B, B.transpose() * RandomMatrix(8, 1, &random)}, "of 12 rows and rank 8");
  if (HasFatalFailure()) return;
  VecX A(4);
  A << 5e-8, 0.0, 9e-9, 1e-7;
  CheckFactor({A.asDiagonal(), VecX::Ones(4)}, "with the eigenvalues 1e-7, 5e-8, 9e-9 and 0");
}

// ---- 6f GetParameterBlocks ----------------------------------------------------------------------------------------

TEST(Stage6, PriorStandsOnTheShiftedBlocks) {
  const FactorScene scene;
  const auto term = scene.Fill();
  term->PreMarginalize();
  std::map<int, VecX> x0;
  for (const auto& vertex : scene.free) x0[vertex->Id()] = vertex->Parameters();
  const auto kept = scene.Kept();
  const auto taker = scene.Dropped().front();  // the window slides: the pose in front takes over
  const std::map<int, std::shared_ptr<Vertex>> shift{{kept[0]->Id(), taker}};
  for (const auto& vertex : scene.free) vertex->Plus(VecX::Constant(9, 0.1).eval().data());  // later
  const Prior prior = term->GetParameterBlocks(shift);
  auto right = kept;
  right[0] = taker;
  if (prior.vertices != right) {
    FAIL() << Story(
        "6", "the prior's vertices, where " + NameOf(*taker) + " takes the place of " + NameOf(*kept[0]),
        std::to_string(right.size()) + " vertices, that one first",
        prior.vertices == kept ? "the vertices before the shift" : std::to_string(prior.vertices.size()) + " others",
        prior.vertices == kept ? "the shift was forgotten: the prior would speak of states that have moved on"
                               : "a vertex that the shift does not name stays itself: block.vertex",
        "6f");
  }
  for (size_t k = 0; k < kept.size(); ++k) {
    if (k < prior.x0.size() && Equal(prior.x0[k], x0[kept[k]->Id()], 1e-12)) continue;
    const bool now = k < prior.x0.size() && (Equal(prior.x0[k], kept[k]->Parameters(), 1e-12) ||
                                             Equal(prior.x0[k], right[k]->Parameters(), 1e-12));
    FAIL() << Story("6", "the linearisation point of " + NameOf(*kept[k]), "its parameters in PreMarginalize",
                    k >= prior.x0.size() ? "nothing"
                    : now                ? "its parameters now"
                                         : "other numbers",
                    "A and b were made at block.x0; whatever the vertex does later, that stays", "6f");
  }
}

// ---- all of it ----------------------------------------------------------------------------------------------------

TEST(Stage6, EqualsADenseSchurComplement) {
  const FactorScene scene;
  const auto term = scene.Fill();
  term->PreMarginalize();
  term->ConstructA();
  term->Factor(term->SchurComplement());
  const Prior prior = term->GetParameterBlocks({});
  const SchurCase c(scene.MatrixA({}), scene.VectorB({}), scene.DimDropped());
  ASSERT_NO_STORY({"6",
                   "JᵀJ of the prior after one marginalisation",
                   c.Schur(c.mm_pinv),
                   prior.J.transpose() * prior.J,
                   {},
                   {},
                   1e-8});
  ASSERT_NO_STORY({"6",
                   "Jᵀr₀ of the prior after one marginalisation",
                   c.Reduced(c.mm_pinv),
                   prior.J.transpose() * prior.r0,
                   {},
                   {},
                   1e-8});
}

}  // namespace
}  // namespace ch5::homework
