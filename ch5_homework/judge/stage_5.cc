/// Stage 5: OKVIS's MarginalizationError. Its functions are called one by one, on matrices without structure that could
/// hide a mistake; the first failure ends the check. At the end the whole class is held against a dense Schur complement.
/// Stage 5.1 is judged in stage_5_insert.cc.

#include <gtest/gtest.h>

#include "ch5_homework/judge/mistakes/stage_5.h"
#include "ch5_homework/judge/scenes.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

using namespace stage_5;

// ---- 5.2 SchurComplement --------------------------------------------------------------------------------------------

Names NamesOfPoses(int count) {
  Graph graph;
  Ordering ordering;
  for (const auto& pose : AddPoses(&graph, count)) ordering.poses.push_back(pose);
  return RowNames(ordering);
}

void CheckSchur(int poses, int goes) {
  Random random(Seed(37));
  const SchurCase c(6 * poses, goes, &random);
  const std::string scene = " after SchurComplement, " + std::to_string(poses) + " poses stay, " +
                            std::to_string(goes) + (goes == 1 ? " row goes" : " rows go");
  MatXX U = c.U;
  VecX b_a = c.b_a;
  Chosen().make_okvis_term()->SchurComplement(c.V, c.W, c.b_b, &U, &b_a);
  ASSERT_NO_STORY(
      {"5", "U" + scene, c.U - c.Subtracted(), U, NamesOfPoses(poses), c.Mistakes(), 1e-9, {}, "5.2", "*U"});
  ASSERT_NO_STORY({"5",
                   "b_a" + scene,
                   c.b_a - c.W * (c.V_inverse * c.b_b),
                   b_a,
                   NamesOfPoses(poses),
                   c.MistakesInB(),
                   1e-9,
                   {},
                   "5.2",
                   "*b_a"});
}

TEST(Stage5, EliminatesADenseBlock) { CheckSchur(1, 6); }  // sizes that hide an exchange
TEST(Stage5, EliminatesAPoint) { CheckSchur(Vary(2, 4, 38), 3); }
TEST(Stage5, EliminatesAnInverseDepth) { CheckSchur(Vary(2, 4, 39), 1); }

TEST(Stage5, EliminatesASingularBlock) {  // a landmark seen once: its depth is unknown
  Random random(Seed(41));
  const MatXX A = RandomMatrix(2, 3, &random), B = RandomMatrix(2, 6, &random), V = A.transpose() * A;
  const VecX r = RandomMatrix(2, 1, &random);
  MatXX U = B.transpose() * B + MatXX::Identity(6, 6);
  VecX b_a = RandomMatrix(6, 1, &random);
  const MatXX V_pinv = PseudoInversePsd(V);  // [A B]ᵀ[A B]: W and b_b lie in the range of V
  const MatXX W = B.transpose() * A;
  const VecX b_b = -A.transpose() * r;
  const MatXX right_U = U - W * V_pinv * W.transpose(), right_b = b_a - W * (V_pinv * b_b);
  Chosen().make_okvis_term()->SchurComplement(V, W, b_b, &U, &b_a);
  if (Equal(U, right_U, 1e-7) && Equal(b_a, right_b, 1e-7)) return;
  FAIL() << Story("5", "SchurComplement with a V of 3 rows and rank 2, a point of unknown depth",
                  "U(0, 0) = " + Number(right_U(0, 0)), "U(0, 0) = " + Number(U(0, 0)),
                  "V has no inverse here: only V_inv_sqrt, the root of its pseudo-inverse, will do", "5.2");
}

TEST(Stage5, EliminatesABlockThatNothingObserves) {
  Random random(Seed(42));
  const MatXX U = RandomPositiveDefinite(6, &random);
  const VecX b_a = RandomMatrix(6, 1, &random);
  MatXX got_U = U;
  VecX got_b = b_a;
  Chosen().make_okvis_term()->SchurComplement(MatXX::Zero(1, 1), MatXX::Zero(6, 1), VecX::Zero(1), &got_U, &got_b);
  if (Equal(got_U, U, 1e-12) && Equal(got_b, b_a, 1e-12)) return;
  FAIL() << Story("5", "SchurComplement with V = 0, W = 0 and b_b = 0", "U and b_a stay as they are",
                  "U(0, 0) = " + Number(got_U(0, 0)), "where V is 0, its pseudo-inverse is 0 too, not infinite", "5.2");
}

// ---- 5.3 UpdateErrorComputation -------------------------------------------------------------------------------------

void CheckSizesAndNumbers(const MatXX& J, const VecX& e0, const MatXX& H, const VecX& b0, const std::string& scene) {
  if (J.cols() != H.cols() || e0.size() != J.rows()) {
    const auto size = [](const MatXX& A) { return std::to_string(A.rows()) + "×" + std::to_string(A.cols()); };
    FAIL() << Story("5", "the sizes of J and e0" + scene, size(H) + " and " + size(b0), size(J) + " and " + size(e0),
                    J.size() == 0 && H.size() > 0 ? "still empty: nothing was assigned to J_"
                    : e0.size() == 0              ? "still empty: nothing was assigned to e0_"
                                     : "J must have a column for each row of H, and e0 a row for each row of J",
                    "5.3");
  }
  const bool finite = J.allFinite() && e0.allFinite();
  if (!finite && !HoldsUnset(J) && !HoldsUnset(e0)) {
    FAIL() << Story("5", "J and e0" + scene, "finite numbers", "infinity or NaN",
                    "an eigenvalue of zero was divided by: take S_pinv_sqrt, where it stays zero", "5.3");
  }
}

void CheckUpdate(const MatXX& H, const VecX& b0, const Names& names, const std::string& scene) {
  const auto term = Chosen().make_okvis_term();
  const OkvisTerm::Members inside = term->Inside();
  *inside.H = H;
  *inside.b0 = b0;
  term->UpdateErrorComputation();
  const MatXX& J = *inside.J;
  const VecX& e0 = *inside.e0;
  CheckSizesAndNumbers(J, e0, H, b0, scene);
  if (::testing::Test::HasFatalFailure()) return;
  const Factored right(H, b0);
  // Awkward units must not hide small entries: everything is compared in units of the diagonal.
  const auto scaled = [&](const MatXX& A) { return MatXX(right.P_inverse * A * right.P_inverse); };
  std::vector<Mistake> mistakes, mistakes_in_e0;
  for (const Mistake& m : right.Mistakes()) mistakes.push_back({m.todo, m.cause, [=] { return scaled(m.answer()); }});
  for (const Mistake& m : right.MistakesInE0()) {
    mistakes_in_e0.push_back({m.todo, m.cause, [=] { return MatXX(right.P_inverse * m.answer()); }});
  }
  ASSERT_NO_STORY({"5",
                   "JᵀJ, which must be H (both in units of √diag H)" + scene,
                   scaled(H),
                   scaled(J.transpose() * J),
                   names,
                   mistakes,
                   1e-9,
                   {},
                   "5.3",
                   "J_"});
  ASSERT_NO_STORY({"5",
                   "Jᵀe0, which must be −b0 (in units of √diag H)" + scene,
                   right.P_inverse * -b0,
                   right.P_inverse * J.transpose() * e0,
                   names,
                   mistakes_in_e0,
                   1e-7,
                   {},
                   "5.3",
                   "e0_"});
}

TEST(Stage5, TakesTheRootOfARegularH) {
  Random random(Seed(43));
  const MatXX H = RandomPositiveDefinite(12, &random);
  CheckUpdate(H, RandomMatrix(12, 1, &random), NamesOfPoses(2), " of two poses, H regular");
}

TEST(Stage5, TakesTheRootOfASingularH) {  // as after every marginalisation without an absolute measurement
  Random random(Seed(47));
  const MatXX A = RandomMatrix(7, 12, &random);
  CheckUpdate(A.transpose() * A, -A.transpose() * RandomMatrix(7, 1, &random), NamesOfPoses(2),
              " of two poses, H of rank 7");
}

TEST(Stage5, TakesTheRootInAwkwardUnits) {
  Random random(Seed(53));
  // So far apart that without P an eigenvalue would count as zero.
  const VecX units = (VecX(6) << 1e6, 1.0, 1e-3, 1.0, 1e2, 1e-2).finished();
  CheckUpdate(units.asDiagonal() * RandomPositiveDefinite(6, &random) * units.asDiagonal(),
              units.asDiagonal() * RandomMatrix(6, 1, &random), NamesOfPoses(1), " of a pose in awkward units");
}

// ---- 5.4 Residual ---------------------------------------------------------------------------------------------------

TEST(Stage5, TheResidualMovesWithTheStates) {
  Random random(Seed(59));
  const auto term = Chosen().make_okvis_term();
  const OkvisTerm::Members inside = term->Inside();
  const MatXX J = RandomMatrix(6, 6, &random);
  const VecX e0 = RandomMatrix(6, 1, &random), delta_chi = RandomMatrix(6, 1, &random);
  *inside.J = J;
  *inside.e0 = e0;
  const MatXX e = term->Residual(delta_chi);
  const auto is = [](const VecX& answer) { return [answer] { return MatXX(answer); }; };
  ASSERT_NO_STORY({"5",
                   "e of a random J and e0",
                   e0 + J * delta_chi,
                   e,
                   {},
                   {{"5.4", "J Δχ is missing: the residual does not move with the states", is(e0)},
                    {"5.4", "e₀ is missing", is(J * delta_chi)},
                    {"5.4", "the sign: it is e₀ + J Δχ", is(e0 - J * delta_chi)},
                    {"5.4", "the signs: it is e₀ + J Δχ", is(J * delta_chi - e0)},
                    {"5.4", "Jᵀ stands where J is meant", is(e0 + J.transpose() * delta_chi)},
                    {"5.4", "J is missing before Δχ", is(e0 + delta_chi)}},
                   1e-10,
                   {},
                   "5.4",
                   "e"});
}

// ---- all together ---------------------------------------------------------------------------------------------------

TEST(Stage5, TheWholeTermIsTheDenseSchurComplement) {
  Graph graph;
  Random random(Seed(61));
  const auto poses = AddPoses(&graph, 3);
  const auto points = AddPoints(&graph, 2);
  const auto depths = AddInverseDepths(&graph, 2);
  for (const auto& pose : poses) {
    for (const auto& point : points) AddRandomEdge<4>(&graph, &random, point, pose);
  }
  for (const auto& depth : depths) AddRandomEdge<2>(&graph, &random, depth, poses[0], poses[2]);
  AddRandomEdge<6>(&graph, &random, poses[0], poses[1]);
  const OkvisTerm::Remainder rest = Chosen().make_okvis_term()->Marginalize(
      graph.Edges(), {points[0], poses[0], points[1], depths[1], depths[0]}, {poses[1], poses[2]});

  const Ordering ordering = MakeOrdering(graph);
  const System all = StackedNormalEquations(graph, ordering.Size());
  std::vector<int> stay, go;
  for (int k = 0; k < ordering.Size(); ++k) (6 <= k && k < 18 ? stay : go).push_back(k);
  const MatXX H_rm = all.H(stay, go), H_mm_inverse = PseudoInversePsd(all.H(go, go));
  const MatXX H = all.H(stay, stay) - H_rm * H_mm_inverse * H_rm.transpose();
  const VecX b = all.b(stay) - H_rm * (H_mm_inverse * all.b(go));
  Names names = RowNames(ordering);
  names = {names.begin() + 6, names.begin() + 18};
  ASSERT_NO_STORY({"5", "H after pose 0 and all landmarks have gone", H, rest.H, names, {}, 1e-8});
  ASSERT_NO_STORY({"5", "b0 after pose 0 and all landmarks have gone", b, rest.b0, names, {}, 1e-8});
  ASSERT_NO_STORY({"5", "JᵀJ of the prior that remains", H, rest.J.transpose() * rest.J, names, {}, 1e-8});
}

}  // namespace
}  // namespace ch5::homework
