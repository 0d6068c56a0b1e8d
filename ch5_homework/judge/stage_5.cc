/// Stage 5: OKVIS's MarginalizationError. Its functions are called one by one, on matrices without structure that could
/// hide a mistake; the first failure ends the check. At the end the whole class is held against a dense Schur complement.

#include <gtest/gtest.h>

#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/psd.h"
#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/fingerprint.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework {
namespace {

// ---- 5.1 InsertBlock ------------------------------------------------------------------------------------------------

Text After(const char* what, const Text& scene) { return {"5.after_insert", {{"what", Word(what)}, {"scene", scene}}}; }

/// A term over poses and landmarks with random numbers, and one more vertex to come.
void CheckInsertion(const VertexList& dense, const VertexList& landmarks, const std::shared_ptr<Vertex>& coming,
                    const Text& scene, double unit = 1.0) {
  Graph graph;
  for (const auto* vertices : {&dense, &landmarks}) {
    for (const auto& vertex : *vertices) graph.AddVertex(vertex);
  }
  graph.AddVertex(coming);
  const bool is_landmark = coming->GetRole() == Role::kLandmark;
  const Names own = RowNames(VertexList{coming}), of_landmarks = RowNames(landmarks),
              names = RowNames(dense) + (is_landmark ? of_landmarks + own : own + of_landmarks);

  Random random(Seed(31));
  const int dense_size = RowsOf(dense), size = dense_size + RowsOf(landmarks);
  const MatXX H = unit * RandomPositiveDefinite(size, &random);
  const VecX b0 = unit * RandomMatrix(size, 1, &random);
  const int row = is_landmark ? size : dense_size, dim = coming->LocalDimension();
  const Answer got = Ask(
      "InsertBlock", {{"H", H}, {"b0", b0}, {"dense_size", dense_size}, {"dim", dim}, {"is_landmark", is_landmark}});
  const right::OpenedTerm right(H, b0, row, dim);
  Require({After("H", scene), "5.1", "H", names}, right.H, got["H"]);
  Require({After("b0", scene), "5.1", "b0", names}, right.b, got.Vector("b0"));
  if (got.Int("dense_size") != dense_size) {
    Fail({After("dense_size_", scene), Text("5.as_before", {{"size", Word(dense_size)}}), Word(got.Int("dense_size")),
          "5.dense_size_grows_twice", "5.1"});
  }
  if (got.Int("row") != row) Fail({"5.returns_first_row"});
}

std::shared_ptr<Vertex> Pose() { return std::make_shared<VertexPose>(); }
std::shared_ptr<Vertex> Point() { return std::make_shared<VertexPointXYZ>(Vec3(1, 2, 5)); }
std::shared_ptr<Vertex> Depth() { return std::make_shared<VertexInverseDepth>(0.2); }
std::shared_ptr<Vertex> SpeedBias() { return std::make_shared<VertexSpeedBias>(); }

VertexList Poses(int count) {
  VertexList poses(static_cast<size_t>(count));
  std::generate(poses.begin(), poses.end(), &Pose);
  return poses;
}

TEST(Stage5, InsertsAPoseBetweenPartsOfOneSize) {  // first: here no assertion betrays an exchange
  CheckInsertion({Pose()}, {Point(), Point()}, Pose(), "5.pose_comes");
}
TEST(Stage5, InsertsASpeedAndBias) {
  const auto comes = [](int poses, int landmarks) {
    return Text("5.speed_bias_comes", {{"n", Word(poses)}, {"m", Word(landmarks)}});
  };
  CheckInsertion({Pose(), Pose()}, {Depth(), Point()}, SpeedBias(), comes(2, 2));
  const auto poses = Poses(Vary(5, 8, 32));  // more rows than a matrix of a student's own size may have
  CheckInsertion(poses, {Point(), Depth(), Point(), Point()}, SpeedBias(), comes(static_cast<int>(poses.size()), 4));
  CheckInsertion({Pose(), Pose()}, {Depth(), Point()}, SpeedBias(), comes(2, 2), 1e9);
}
TEST(Stage5, AppendsALandmark) {
  CheckInsertion({Pose(), SpeedBias()}, {Point(), Depth()}, Point(), "5.landmark_comes");
  CheckInsertion(Poses(Vary(5, 8, 33)), {Point(), Depth()}, Point(), "5.landmark_comes");
}
TEST(Stage5, InsertsTheFirstBlocks) {
  CheckInsertion({}, {}, Pose(), "5.pose_comes_nothing");
  CheckInsertion({}, {Depth(), Depth()}, Pose(), "5.pose_comes_only_two_landmarks");
}

// ---- 5.2 SchurComplement --------------------------------------------------------------------------------------------

Names NamesOfPoses(int count) {
  Graph graph;
  AddPoses(&graph, count);
  return RowNames(graph.Vertices());
}

// The function's U and b_a.
System Eliminated(const MatXX& V, const MatXX& W, const VecX& b_b, const MatXX& U, const VecX& b_a) {
  const Answer got =
      Ask("MarginalizationError::SchurComplement", {{"V", V}, {"W", W}, {"b_b", b_b}, {"U", U}, {"b_a", b_a}});
  return {got["U"], got.Vector("b_a")};
}

// @param unit  of what goes;  @param weight  of all
void CheckSchur(int poses, int goes, double unit = 1.0, double weight = 1.0) {
  Random random(Seed(37));
  const MatXX V = weight * unit * unit * RandomPositiveDefinite(goes, &random),
              W = weight * unit * RandomMatrix(6 * poses, goes, &random);
  const VecX b_b = weight * unit * RandomMatrix(goes, 1, &random),
             b_a_before = weight * RandomMatrix(6 * poses, 1, &random);
  const MatXX U_before = weight * RandomPositiveDefinite(6 * poses, &random) + W * PseudoInversePsd(V) * W.transpose();
  const auto of = [&](const char* what) {
    const Text word = Word(what);
    if (goes == 1) return Text("5.after_schur_one_row", {{"what", word}, {"n", Word(poses)}});
    return Text("5.after_schur_rows", {{"what", word}, {"n", Word(poses)}, {"m", Word(goes)}});
  };
  const System got = Eliminated(V, W, b_b, U_before, b_a_before);
  const right::SchurUpdate right(V, W, b_b, U_before, b_a_before);
  Require({of("U"), "5.2", "*U", NamesOfPoses(poses), 1e-9}, right.U, got.H);
  Require({of("b_a"), "5.2", "*b_a", NamesOfPoses(poses), 1e-9}, right.b_a, got.b);
}

TEST(Stage5, EliminatesADenseBlock) {
  CheckSchur(1, 6);                // sizes that hide an exchange
  CheckSchur(Vary(3, 5, 36), 15);  // an OKVIS frame with its speed and biases
}
TEST(Stage5, EliminatesAPoint) {
  CheckSchur(Vary(2, 4, 38), 3);
  CheckSchur(2, 3, 1e-3);  // in small units
  CheckSchur(2, 3, 1.0, 1e9);
}
TEST(Stage5, EliminatesAnInverseDepth) { CheckSchur(Vary(2, 4, 39), 1); }

void CheckSingular(const Text& scene, const System& right, const System& got, double tolerance, const Text& infinite) {
  if (Equal(got.H, right.H, tolerance) && Equal(got.b, right.b, tolerance)) return;
  const auto first = [](const MatXX& U) {
    return Word("U(0, 0) = " + (U.size() > 0 ? Number(U(0, 0)) : std::string("?")));
  };
  Fail({scene,
        first(right.H),
        first(got.H),
        got.H.allFinite() ? "5.V_no_inverse" : infinite,
        "5.5 5.2",
        {},
        Fingerprint(right.H, got.H)});
}

// First an eigenvalue that is exactly zero: the inverse of one that is zero to rounding depends on the rounding's sign.
TEST(Stage5, EliminatesABlockThatNothingObserves) {
  Random random(Seed(42));
  const MatXX U = RandomPositiveDefinite(6, &random);
  const VecX b_a = RandomMatrix(6, 1, &random);
  // Two landmarks, only the first observed: changing nothing must not pass either.
  const double v = random.Uniform(1.0, 2.0), b = random.Normal();
  const VecX w = RandomMatrix(6, 1, &random);
  const MatXX V = Vec2(v, 0.0).asDiagonal(), W = w * Vec2(1.0, 0.0).transpose();
  CheckSingular("5.one_of_two_observed", {U - w * w.transpose() / v, b_a - w * (b / v)},
                Eliminated(V, W, Vec2(b, 0.0), U, b_a), 1e-10, "5.pinv_of_zero_is_zero");
}

TEST(Stage5, EliminatesASingularBlock) {  // a landmark seen once: its depth is unknown
  Random random(Seed(41));
  const MatXX A = RandomMatrix(2, 3, &random), B = RandomMatrix(2, 6, &random), V = A.transpose() * A;
  const VecX r = RandomMatrix(2, 1, &random);
  const MatXX U = B.transpose() * B + MatXX::Identity(6, 6);
  const VecX b_a = RandomMatrix(6, 1, &random);
  const MatXX V_pinv = PseudoInversePsd(V);  // [A B]ᵀ[A B]: W and b_b lie in the range of V
  const MatXX W = B.transpose() * A;
  const VecX b_b = -A.transpose() * r;
  CheckSingular("5.singular_V", {U - W * V_pinv * W.transpose(), b_a - W * (V_pinv * b_b)},
                Eliminated(V, W, b_b, U, b_a), 1e-7, "5.V_no_inverse");
}

// ---- 5.3 UpdateErrorComputation -------------------------------------------------------------------------------------

void CheckSizesAndNumbers(const MatXX& J, const VecX& e0, const MatXX& H, const VecX& b0, const Text& scene) {
  if (J.cols() != H.cols() || e0.size() != J.rows()) {
    const auto sizes = [](const MatXX& A, const MatXX& B) {
      return Text("5.two_sizes",
                  {{"a", Word(A.rows())}, {"b", Word(A.cols())}, {"c", Word(B.rows())}, {"d", Word(B.cols())}});
    };
    Fail({Text("5.sizes_J_e0", {{"scene", scene}}), sizes(H, b0), sizes(J, e0),
          J.size() == 0 && H.size() > 0 ? Text("matrix.still_empty", {{"variable", Word("J_")}})
          : e0.size() == 0              ? Text("matrix.still_empty", {{"variable", Word("e0_")}})
                                        : "5.sizes_of_J_and_e0",
          "5.3"});
  }
  const bool finite = J.allFinite() && e0.allFinite();
  if (!finite && !HoldsUnset(J) && !HoldsUnset(e0)) {
    const bool unmeasured_row = (H.diagonal().array() == 0.0).any();
    Fail({Text("5.J_e0", {{"scene", scene}}), "matrix.finite_numbers", "5.infinity_or_nan",
          unmeasured_row ? "5.zero_on_the_diagonal" : "5.divided_by_zero_eigenvalue",
          unmeasured_row ? "5.6 5.3" : "5.7 5.3"});
  }
}

// JᵀJ with another P: H again, but for the eigenvalues that then count as zero.
MatXX GramScaledBy(const MatXX& H, const VecX& p) {
  const ScaledEigen eigen = DecomposeScaled(H, p.cwiseInverse());
  const MatXX J = eigen.S_sqrt.asDiagonal() * eigen.U.transpose() * p.asDiagonal();
  return J.transpose() * J;
}

// The formula's slips are of J = (P U S^½)ᵀ; e0 may be right for another J.
bool IsOfAnotherJ(const right::SquareRoot& right, const MatXX& J, const VecX& Jte0) {
  const VecX minus_b0 = Value(right.Jte0.right);
  const bool is_multiple = std::abs(minus_b0.dot(Jte0)) > (1.0 - 1e-9) * minus_b0.norm() * Jte0.norm();
  return !is_multiple && !Equal(J.cwiseAbs(), Value(right.Jte0.beside.back()).cwiseAbs(), 1e-6);
}

void CheckUpdate(const MatXX& H, const VecX& b0, const Names& names, const Text& scene) {
  const Answer got = Ask("UpdateErrorComputation", {{"H", H}, {"b0", b0}});
  const MatXX J_before = got["J_before"], e0_before = got["e0_before"], J = got["J"];  // before: 5 H and 3 b0 are given
  const VecX e0 = got.Vector("e0");
  CheckSizesAndNumbers(J, e0, H, b0, scene);
  const right::SquareRoot right(H, b0);
  // Awkward units must not hide small entries: everything is compared in units of the diagonal.
  const VecX p_inverse = right.p.cwiseInverse();
  const auto scaled = [&](const MatXX& A) { return MatXX(p_inverse.asDiagonal() * A * p_inverse.asDiagonal()); };
  const MatXX JtJ = scaled(J.transpose() * J), Jte0 = p_inverse.asDiagonal() * (J.transpose() * e0);
  const auto kept = [](const char* variable, const MatXX& now, const MatXX& before, const MatXX& answer) {
    const Text cause("matrix.of_an_earlier_call", {{"variable", Word(std::string(variable))}});
    return Mistake{"5.3", cause, Equal(now, before, 0.0) ? answer : MatXX()};
  };
  const bool far_apart = right.p.maxCoeff() > 1e6 * right.p.minCoeff();
  if (far_apart && Equal(JtJ, scaled(H), 0.1) && !Equal(JtJ, scaled(H), 1e-9)) {  // no eigenvalue of H was cut
    Fail({Text("5.JTJ_is_H", {{"scene", scene}}), {}, {}, "5.no_scaling", "5.6 5.3"});
  }
  const ScaledEigen eigen = DecomposeScaled(H, p_inverse);
  Mistakes in_JtJ{CholeskyOfSingular("5.3", "H", eigen.S_sqrt, J, JtJ),
                  kept("J_", J, J_before, JtJ),
                  {"5.6 5.3", "5.scaling_inverted", scaled(GramScaledBy(H, right.p.cwiseInverse()))},
                  {"5.6 5.3", "5.diagonal_for_its_root", scaled(GramScaledBy(H, H.diagonal()))},
                  {"5.6 5.3", "5.no_scaling", scaled(GramScaledBy(H, VecX::Ones(H.rows())))}};
  VecX S_sqrt = eigen.S_sqrt;  // without the smallest ones
  for (Eigen::Index k = 0; k + 1 < S_sqrt.size(); ++k) {
    S_sqrt[k] = 0.0;
    const MatXX root = S_sqrt.asDiagonal() * eigen.U.transpose();
    in_JtJ.push_back(
        {"5.7 5.3", {"formula.known_direction_cut", {{"matrix", Word(std::string("H"))}}}, root.transpose() * root});
  }
  const Text of_an_earlier_call("matrix.of_an_earlier_call", {{"variable", Word(std::string("J_pinv_T"))}});
  Mistakes in_Jte0{kept("e0_", e0, e0_before, Jte0),
                   {"5.3", of_an_earlier_call, -p_inverse.cwiseProduct(b0) / std::sqrt(5.0)}};
  if (IsOfAnotherJ(right, J, Jte0)) in_Jte0.push_back({"5.3", "5.e0_of_another_J", Jte0});
  Require({{"5.JTJ_is_H", {{"scene", scene}}}, "5.3", "J_", names, 1e-9, in_JtJ}, right.JtJ, JtJ);
  Require({{"5.JTe0_is_minus_b0", {{"scene", scene}}}, "5.3", "e0_", names, 1e-8, in_Jte0}, right.Jte0, Jte0);
}

// What rounding leaves of b₀ in a direction that H does not know may not be magnified, though J hides it from Jᵀe₀.
void CheckLengthOfE0(const MatXX& H, const VecX& b0, const Text& scene) {
  const Answer answer = Ask("UpdateErrorComputation", {{"H", H}, {"b0", b0}});
  const MatXX J_before = answer["J_before"], e0_before = answer["e0_before"],
              J = answer["J"];  // looked at in CheckUpdate
  const VecX e0 = answer.Vector("e0"), p_inverse = ScalingOf(H).cwiseInverse();
  CheckSizesAndNumbers(J, e0, H, b0, scene);
  const ScaledEigen eigen = DecomposeScaled(H, p_inverse);
  const VecX right = eigen.S_pinv_sqrt.asDiagonal() * (eigen.U.transpose() * p_inverse.cwiseProduct(b0));
  const MatXX got = MatXX::Constant(1, 1, e0.squaredNorm());
  const Mistakes magnified{{"5.7 5.3", "5.e0_magnified", e0.norm() > right.norm() ? got : MatXX()}};
  Require({{"5.e0_squared", {{"scene", scene}}}, "5.3", "e0_", {}, 1e-5, magnified},
          MatXX::Constant(1, 1, right.squaredNorm()), got);
}

TEST(Stage5, TakesTheRootOfARegularH) {
  Random random(Seed(43));
  const MatXX H = RandomPositiveDefinite(12, &random);
  const auto poses = [](int count) { return Text("5.poses_H_regular", {{"n", Word(count)}}); };
  CheckUpdate(H, RandomMatrix(12, 1, &random), NamesOfPoses(2), poses(2));
  MatXX A = RandomMatrix(12, 12, &random);
  A.row(0) *= 1e-2;
  CheckUpdate(A.transpose() * A, A.transpose() * RandomMatrix(12, 1, &random), NamesOfPoses(2), "5.two_poses_H_weak");
  const int many = Vary(5, 8, 44);
  const MatXX large = RandomPositiveDefinite(6 * many, &random);
  CheckUpdate(large, RandomMatrix(6 * many, 1, &random), NamesOfPoses(many), poses(many));
  CheckUpdate(1e9 * large, 1e9 * RandomMatrix(6 * many, 1, &random), NamesOfPoses(many), poses(many));
}

TEST(Stage5, TakesTheRootOfASingularH) {  // as after every marginalization without an absolute measurement
  Random random(Seed(47));
  MatXX A = RandomMatrix(7, 12, &random);
  const VecX r = RandomMatrix(7, 1, &random);
  for (const double times : {1.0, 1e-9, 0.0})  // measurements that contradict nothing, too, have a root
    CheckUpdate(A.transpose() * A, -times * A.transpose() * r, NamesOfPoses(2), "5.two_poses_H_singular");
  CheckLengthOfE0(A.transpose() * A, 1e-7 * RandomMatrix(12, 1, &random) - A.transpose() * r, "5.two_poses_H_singular");
  A.col(4).setZero();
  CheckUpdate(A.transpose() * A, -A.transpose() * r, NamesOfPoses(2), "5.two_poses_with_an_unmeasured_row");
}

TEST(Stage5, TakesTheRootInAwkwardUnits) {
  Random random(Seed(53));
  // So far apart that without P an eigenvalue counts as zero, or drowns in the rounding of the largest one.
  const VecX units = (VecX(6) << 1e-3, 1.0, 1e-2, 1e2, 1.0, 1e6).finished();
  CheckUpdate(units.asDiagonal() * RandomPositiveDefinite(6, &random) * units.asDiagonal(),
              units.asDiagonal() * RandomMatrix(6, 1, &random), NamesOfPoses(1), "5.pose_in_awkward_units");
}

// ---- 5.4 Residual ---------------------------------------------------------------------------------------------------

void CheckResidual(int n, double farthest, double nearest, Random* random) {
  const MatXX J = RandomMatrix(n, n, random);
  const VecX e0 = RandomMatrix(n, 1, random);
  MatXX motions = MatXX::Zero(n, 4);  // linear however far the states move; the last column is no motion
  for (const double size : {farthest, 1.0, nearest}) {
    motions.leftCols(3) << motions.middleCols(1, 2).eval(), size * RandomMatrix(n, 1, random);
  }
  const Answer got = Ask("Residual", {{"J", J}, {"e0", e0}, {"delta_chi", motions}});
  for (int k = 0; k < 3; ++k) {
    const VecX delta_chi = motions.col(k);
    const MatXX& e = got[Numbered("e", k)];
    Require({Text("5.e_of", {{"what", "5.random_J_e0"}}), "5.4", "e"}, right::Residual(J, e0, delta_chi), e);
  }
  Require({{"5.e_of", {{"what", "5.no_motion"}}}, "5.4", {}, {}, 1e-10, {{"5.4", "5.e0_missing", VecX::Zero(n)}}}, e0,
          got["e 3"]);
}

TEST(Stage5, TheResidualMovesWithTheStates) {
  Random random(Seed(59));
  for (const int n : {9, Vary(30, 40, 60)}) CheckResidual(n, 30.0, 0.03, &random);  // more than a pose has
  CheckResidual(9, 1e9, 1e-6, &random);
}

// ---- all together ---------------------------------------------------------------------------------------------------

TEST(Stage5, TheWholeTermIsTheDenseSchurComplement) {
  GraphScene scene("poses and landmarks");
  const Graph& graph = scene.graph;
  const VecX out = (VecX(5) << 3, 0, 4, 6, 5).finished();  // of 3 poses, 2 points, 2 inverse depths; 1 and 2 are left
  const Answer term = Ask("MarginalizationError", scene, {{"out", out}});

  const Ordering ordering = MakeOrdering(graph);
  const System all = StackedNormalEquations(graph, ordering.Size());
  std::vector<int> stay, go;
  for (int k = 0; k < ordering.Size(); ++k) (6 <= k && k < 18 ? stay : go).push_back(k);
  const MatXX H_rm = all.H(stay, go), H_mm_inverse = PseudoInversePsd(all.H(go, go));
  const MatXX H = all.H(stay, stay) - H_rm * H_mm_inverse * H_rm.transpose();
  const VecX b = all.b(stay) - H_rm * (H_mm_inverse * all.b(go));
  Names names = RowNames(ordering);
  names = {names.begin() + 6, names.begin() + 18};
  const auto require = [&](const char* what, const MatXX& right, const MatXX& got) {
    Require({{"5.in_all", {{"what", Word(what)}}}, {}, {}, names, 1e-8}, right, got);
  };
  require("H", H, term["H"]);
  require("b0", b, term.Vector("b0"));
  require("JᵀJ", H, term["J"].transpose() * term["J"]);
}

}  // namespace
}  // namespace ch5::homework
