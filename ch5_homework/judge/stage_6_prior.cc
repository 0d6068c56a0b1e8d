/// Stage 6, TODOs 6d to 6f: from A and b to a prior, each function on numbers of its own, then all of 6a to 6f together.
/// stage_6.cc comes before, stage_6_drop_sets.cc goes on.

#include <gtest/gtest.h>

#include "ch5_homework/judge/mistakes/stage_6.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

using namespace stage_6;

// ---- 6d SchurComplement -------------------------------------------------------------------------------------------

void CheckSchur(const SchurCase& c, const std::string& what) {
  const auto term = Chosen().make_vins_term();
  const VinsTerm::Members inside = term->Inside();
  *inside.A = c.A;
  *inside.b = c.b;
  *inside.m = c.m;
  *inside.n = c.n();
  const VinsTerm::KeptSystem got = term->SchurComplement();
  if (!got.A.allFinite() && !HoldsUnset(got.A)) {
    FAIL() << Story("6", "A_r " + what, "finite numbers", "infinite ones",
                    "the cut is missing, an eigenvalue of zero was divided by: 1/S only where S > kEps, otherwise 0",
                    "6d");
  }
  ASSERT_NO_STORY({"6", "A_r " + what, c.Schur(c.mm_pinv), got.A, {}, c.Mistakes(), 1e-8, {}, "6d", "kept.A"});
  ASSERT_NO_STORY({"6", "b_r " + what, c.Reduced(c.mm_pinv), got.b, {}, c.MistakesInB(), 1e-8, {}, "6d", "kept.b"});
}

TEST(Stage6, SchurComplementOfTheDroppedRows) {
  Random random(Seed(61));
  for (const auto& [m, n] :
       {std::pair{6, 6}, std::pair{Vary(9, 15, 65), 6}, std::pair{1, 6}, std::pair{21, Vary(12, 18, 66)}}) {
    const MatXX A = RandomPositiveDefinite(m + n, &random);
    const SchurCase c(A, RandomMatrix(m + n, 1, &random), m);
    CheckSchur(c, "where " + std::to_string(m) + " rows go and " + std::to_string(n) + " stay");
    if (HasFatalFailure()) return;
  }
}

// A_mm has the eigenvalues S; the rows of A_mr and of b_m that belong to them are about as large as `rows`.
void CheckTheCut(const VecX& S, const VecX& rows, const std::string& what) {
  Random random(Seed(69));
  const int m = static_cast<int>(S.size()), n = 6;
  MatXX A = RandomPositiveDefinite(m + n, &random);
  VecX b = RandomMatrix(m + n, 1, &random);
  A.topLeftCorner(m, m) = S.asDiagonal();
  A.topRightCorner(m, n) = rows.asDiagonal() * RandomMatrix(m, n, &random);
  A.bottomLeftCorner(n, m) = A.topRightCorner(m, n).transpose();
  b.head(m) = b.head(m).cwiseProduct(rows);
  CheckSchur(SchurCase(A, b, m), what);
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
  if (HasFatalFailure()) return;
  // Far apart: those up to kEps count as zero, however large the largest is.
  const VecX S = (VecX(6) << 2e4, 1e-5, 3e-8, 5e-9, 0.0, 2.0).finished();
  CheckTheCut(S, S.cwiseSqrt(), "where the eigenvalues of A_mm reach from 0 to 2e4");
  if (HasFatalFailure()) return;
  // S⁺ is 0 for them, kEps itself among them, also where A_mr and b_m speak of them.
  CheckTheCut((VecX(3) << 1.0, 1e-8, 0.0).finished(), VecX::Ones(3), "where the eigenvalues of A_mm are 1, kEps and 0");
}

// ---- 6e Factor ----------------------------------------------------------------------------------------------------

void CheckJ(const FactorCase& c, const MatXX& J, const VecX& r0, const std::string& what) {
  if (J.cols() != c.A.rows() || r0.size() != J.rows()) {
    FAIL() << Story(
        "6", "the sizes of J and r₀ " + what,
        "J with " + std::to_string(c.A.rows()) + " columns, r₀ with a row for each row of J",
        "J " + std::to_string(J.rows()) + "×" + std::to_string(J.cols()) + ", r₀ " + std::to_string(r0.size()),
        J.size() == 0    ? "still empty: nothing was assigned to linearized_jacobians_"
        : r0.size() == 0 ? "still empty: nothing was assigned to linearized_residuals_"
                         : "r₀ belongs to the rows of J",
        "6e");
  }
  ASSERT_NO_STORY({"6",
                   "JᵀJ " + what + ", which must be A_r",
                   c.V * c.S * c.V.transpose(),
                   J.transpose() * J,
                   {},
                   c.Mistakes(),
                   1e-9,
                   {},
                   "6e",
                   "linearized_jacobians_"});
}

void CheckR0(const FactorCase& c, const MatXX& J, const VecX& r0, const std::string& what) {
  if (!r0.allFinite() && !HoldsUnset(r0)) {
    FAIL() << Story("6", "r₀ " + what, "finite numbers", "infinite ones",
                    "an eigenvalue of zero was divided by: where S ≤ kEps, S^-½ is 0", "6e");
  }
  const VecX right = c.V * (c.S * c.S_pinv) * c.V.transpose() * c.b;  // b_r in the range of A_r
  ASSERT_NO_STORY({"6",
                   "Jᵀr₀ " + what + ", which must be b_r",
                   right,
                   J.transpose() * r0,
                   {},
                   c.MistakesInR0(),
                   1e-8,
                   {},
                   "6e",
                   "linearized_residuals_"});
  const double cost = c.b.dot(c.V * c.S_pinv * c.V.transpose() * c.b);
  if (std::abs(r0.squaredNorm() - cost) > 1e-8 * cost) {
    FAIL() << Story("6", "r₀ᵀr₀ " + what, Number(cost), Number(r0.squaredNorm()),
                    "eigenvalues up to kEps count in r₀: there S^-½ is 0", "6e");
  }
}

void CheckFactor(const FactorCase& c, const std::string& what) {
  const auto term = Chosen().make_vins_term();
  const VinsTerm::Members inside = term->Inside();
  *inside.n = static_cast<int>(c.A.rows());
  term->Factor({c.A, c.b});
  const MatXX& J = *inside.J;
  const VecX& r0 = *inside.r0;
  CheckJ(c, J, r0, what);
  if (!::testing::Test::HasFatalFailure()) CheckR0(c, J, r0, what);
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
  if (HasFatalFailure()) return;
  A << 2e4, 1e-5, 3.0, 1e-7;
  CheckFactor({A.asDiagonal(), A.cwiseSqrt()}, "with the eigenvalues 2e4, 3, 1e-5 and 1e-7");
  if (HasFatalFailure()) return;
  A << 1.0, 1e-8, 0.0, 0.5;
  CheckFactor({A.asDiagonal(), VecX::Ones(4)}, "with the eigenvalues 1, 1/2, kEps and 0");
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
