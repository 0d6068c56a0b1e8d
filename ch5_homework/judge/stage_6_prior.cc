/// Stage 6, TODOs 6d to 6f: from A and b to a prior, each function on numbers of its own, then all of 6a to 6f together.
/// stage_6.cc comes before, stage_6_drop_sets.cc goes on.

#include <gtest/gtest.h>

#include "ch5_homework/judge/right/formulas.h"
#include "ch5_homework/judge/stage_6_scene.h"

namespace ch5::homework {
namespace {

// ---- 6d SchurComplement -------------------------------------------------------------------------------------------

// Where eigenvectors are unit vectors, the cut alone is looked at: slips elsewhere would give its answer by chance.
void RequireOf(const MatXX& decomposed, const Check& check, formula::Formula right, const MatXX& got) {
  right.listed_alone = decomposed.isDiagonal();
  Require(check, right, got);
}

void CheckSchur(const MatXX& A, const VecX& b, int m, const Text& where) {
  const Answer kept = Ask("MarginalizationInfo::SchurComplement", {{"A", A}, {"b", b}, {"m", m}});
  const auto of = [&](const char* what) { return Text("6.quantity_of", {{"quantity", Word(what)}, {"what", where}}); };
  if (!kept["A"].allFinite() && !HoldsUnset(kept["A"])) {
    Fail({of("A_r"), "matrix.finite_numbers", "6.infinite_ones", "6.cut_missing", "6d"});
  }
  const right::KeptRows right(A, b, m);
  const MatXX A_mm = A.topLeftCorner(m, m);
  RequireOf(A_mm, {of("A_r"), "6d", "kept.A", {}, 1e-8}, right.A_r, kept["A"]);
  RequireOf(A_mm, {of("b_r"), "6d", "kept.b", {}, 1e-8}, right.b_r, kept.Vector("b"));
}

TEST(Stage6, SchurComplementOfTheDroppedRows) {
  Random random(Seed(61));
  for (const auto& [m, n] :
       {std::pair{6, 6}, std::pair{Vary(9, 15, 65), 6}, std::pair{1, 6}, std::pair{21, Vary(12, 18, 66)}}) {
    const MatXX A = RandomPositiveDefinite(m + n, &random);
    const VecX b = RandomMatrix(m + n, 1, &random);
    const Text where("6.where_rows_go_stay", {{"m", Word(m)}, {"n", Word(n)}});
    for (const double unit : {1.0, 1e9}) CheckSchur(unit * A, unit * b, m, where);
  }
}

// A_mm has the eigenvalues S; the rows of A_mr and of b_m that belong to them are about as large as `rows`.
void CheckTheCut(const VecX& S, const VecX& rows, const Text& what) {
  Random random(Seed(69));
  const int m = static_cast<int>(S.size()), n = 6;
  MatXX A = RandomPositiveDefinite(m + n, &random);
  VecX b = RandomMatrix(m + n, 1, &random);
  A.topLeftCorner(m, m) = S.asDiagonal();
  A.topRightCorner(m, n) = rows.asDiagonal() * RandomMatrix(m, n, &random);
  A.bottomLeftCorner(n, m) = A.topRightCorner(m, n).transpose();
  b.head(m) = b.head(m).cwiseProduct(rows);
  CheckSchur(A, b, m, what);
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
  CheckSchur(A, J.transpose() * RandomMatrix(20, 1, &random), m, "6.two_unknown_depths");
  // Far apart: those up to kEps count as zero, however large the largest is.
  const VecX S = (VecX(7) << 2e3, 5e-5, 1.5e-5, 3e-8, 5e-9, 0.0, 2.0).finished();
  CheckTheCut(S, S.cwiseSqrt(), "6.eigenvalues_far_apart");
  // S⁺ is 0 for them, kEps itself among them, also where A_mr and b_m speak of them.
  CheckTheCut((VecX(3) << 2.0, 1e-8, 0.0).finished(), VecX::Ones(3), "6.eigenvalues_eps_zero");
}

// ---- 6e Factor ----------------------------------------------------------------------------------------------------

void CheckSizes(const MatXX& A, const MatXX& J, const VecX& r0, const Text& what) {
  if (J.cols() == A.rows() && r0.size() == J.rows()) return;
  Fail({Text("6.sizes_J_r0", {{"what", what}}), Text("6.J_columns", {{"n", Word(A.rows())}}),
        Text("6.J_r0",
             {{"size", Word(std::to_string(J.rows()) + "×" + std::to_string(J.cols()))}, {"n", Word(r0.size())}}),
        J.size() == 0    ? Text("matrix.still_empty", {{"variable", Word("linearized_jacobians_")}})
        : r0.size() == 0 ? Text("matrix.still_empty", {{"variable", Word("linearized_residuals_")}})
                         : "6.r0_belongs_rows_J",
        "6e"});
}

void CheckFactor(const MatXX& A, const VecX& b, const Text& what) {
  const Answer factored = Ask("Factor", {{"A", A}, {"b", b}});
  const MatXX& J = factored["J"];
  const VecX r0 = factored.Vector("r0");
  const auto of = [&](const char* it) { return Text("6.quantity_of", {{"quantity", Word(it)}, {"what", what}}); };
  const auto must_be = [&](const char* it, const char* that) {
    return Text("6.must_be", {{"what", of(it)}, {"that", Word(that)}});
  };
  CheckSizes(A, J, r0, what);
  const right::Factored right(A, b);
  const MatXX JtJ = J.transpose() * J;
  Require({must_be("JᵀJ", "A_r"),
           "6e",
           "linearized_jacobians_",
           {},
           1e-9,
           {CholeskyOfSingular("6e", "A_r", right.eigenvalues, J, JtJ)}},
          right.JtJ, JtJ);
  if (!r0.allFinite() && !HoldsUnset(r0)) {
    Fail({of("r₀"), "matrix.finite_numbers", "6.infinite_ones", "6.divided_by_zero_eigenvalue", "6e"});
  }
  const MatXX of_another_root = J.rows() == right.r0.size() ? MatXX(J.transpose() * right.r0) : MatXX();
  RequireOf(
      A,
      {must_be("Jᵀr₀", "b_r"), "6e", "linearized_residuals_", {}, 1e-8, {{"6e", "6.J_another_root", of_another_root}}},
      right.Jtr0, J.transpose() * r0);
  const double cost = right.r0.squaredNorm();
  if (std::abs(r0.squaredNorm() - cost) > 1e-8 * cost) {
    Fail({of("r₀ᵀr₀"), Word(cost), Word(r0.squaredNorm()), "6.eigenvalues_up_kEps_count_r0", "6e"});
  }
}

TEST(Stage6, FactorsARegularSystem) {
  Random random(Seed(63));
  for (const int rows : {6, Vary(70, 90, 59)}) {
    const MatXX A = RandomPositiveDefinite(rows, &random);
    const VecX b = RandomMatrix(rows, 1, &random);
    for (const double unit : {1.0, 1e9}) CheckFactor(unit * A, unit * b, {"6.rows", {{"n", Word(rows)}}});
  }
}

TEST(Stage6, FactorsASystemWithFreeDirections) {  // position and yaw: four eigenvalues are zero
  Random random(Seed(64));
  const MatXX B = RandomMatrix(8, 12, &random);
  CheckFactor(B.transpose() * B, B.transpose() * RandomMatrix(8, 1, &random), "6.twelve_rows_rank_eight");
  VecX A(4);
  A << 2e4, 1.5e-5, 3.0, 1e-7;  // first: below, a cut relative to the largest looks like none
  CheckFactor(A.asDiagonal(), A.cwiseSqrt(), "6.eigenvalues_large_and_small");
  A << 5e-8, 0.0, 9e-9, 1e-7;
  CheckFactor(A.asDiagonal(), VecX::Ones(4), "6.eigenvalues_around_eps");
  A << 4e-8, 1e-8, 0.0, 2e-8;  // kEps itself: as large as its neighbors, or it would be lost among them
  CheckFactor(A.asDiagonal(), VecX::Ones(4), "6.eigenvalue_at_eps");
}

// ---- 6f GetParameterBlocks ----------------------------------------------------------------------------------------

// kept: before the window slides; right: after it, when another vertex has taken the first one's place.
void CheckVerticesOfPrior(const VertexList& got, const VertexList& kept, const VertexList& right) {
  if (got == right) return;
  const bool forgotten = got == kept,
             in_another_order = std::is_permutation(got.begin(), got.end(), right.begin(), right.end());
  Fail({Text("6.priors_vertices", {{"taker", Word(right[0]->Name())}, {"vertex", Word(kept[0]->Name())}}),
        Text("6.vertices_one_first", {{"n", Word(right.size())}}),
        forgotten ? "6.vertices_before_shift" : Text("6.others", {{"n", Word(got.size())}}),
        forgotten          ? "6.shift_forgotten"
        : in_another_order ? "6.prior_in_another_order"
                           : "6.unshifted_stays",
        "6f"});
}

TEST(Stage6, PriorStandsOnTheShiftedBlocks) {
  FactorScene scene;
  const auto kept = scene.Kept();
  // The window slides: the pose in front takes over, and another vertex from the last one.
  const auto dropped = scene.Dropped();
  const Eigen::Vector2d from(scene.PlaceOf(kept.front()), scene.PlaceOf(kept.back())),
      to(scene.PlaceOf(dropped.front()), scene.PlaceOf(dropped.back()));
  const VecX later = VecX::Constant(9, 0.1);
  const Answer prior = Ask("GetParameterBlocks", scene, {{"from", from}, {"to", to}, {"later", later}});
  VertexList got;
  for (const double place : prior.Vector("vertices")) got.push_back(place < 0.0 ? nullptr : scene.At(place));
  std::map<int, VecX> x0;
  for (const auto& vertex : scene.free) x0[vertex->Id()] = vertex->Parameters();
  for (const auto& vertex : scene.free) vertex->Plus(later.data());
  auto right = kept;
  right.front() = dropped.front(), right.back() = dropped.back();
  CheckVerticesOfPrior(got, kept, right);
  for (size_t k = 0; k < kept.size(); ++k) {
    const std::string name = Numbered("x0", k);
    const bool is_there = prior.Has(name);
    const VecX point = is_there ? prior.Vector(name) : VecX();
    if (Equal(point, x0[kept[k]->Id()], 1e-12)) continue;
    const bool of_another = std::any_of(kept.begin(), kept.end(),
                                        [&](const auto& vertex) { return Equal(point, x0[vertex->Id()], 1e-12); });
    const bool now = Equal(point, kept[k]->Parameters(), 1e-12) || Equal(point, right[k]->Parameters(), 1e-12);
    Fail({Text("6.linearization_point", {{"vertex", Word(kept[k]->Name())}}), "6.parameters_premarginalize",
          !is_there ? "6.nothing"
          : now     ? "6.parameters_now"
                    : "6.other_numbers",
          of_another && !prior.Has(Numbered("x0", kept.size()))  ? "6.prior_in_another_order"
          : is_there && point.size() != x0[kept[k]->Id()].size() ? "6.x0_of_another_size"
                                                                 : "6.linearized_at_x0",
          "6f"});
  }
}

// ---- all of it ----------------------------------------------------------------------------------------------------

TEST(Stage6, EqualsADenseSchurComplement) {
  FactorScene scene;
  const Answer prior = Ask("Marginalize", scene);
  const MatXX& J = prior["J"];
  const VecX r0 = prior.Vector("r0");
  if (r0.size() != J.rows()) throw WireError("J and r0 do not fit together");
  const System right = scene.Right();
  const right::KeptRows kept(right.H, right.b, scene.DimDropped());
  const auto require = [](const char* quantity, const formula::Formula& formula, const MatXX& got) {
    Require({{"6.of_prior", {{"quantity", Word(quantity)}}}, {}, {}, {}, 1e-8}, Value(formula.right), got);
  };
  require("JᵀJ", kept.A_r, J.transpose() * J);
  require("Jᵀr₀", kept.b_r, J.transpose() * r0);
}

}  // namespace
}  // namespace ch5::homework
