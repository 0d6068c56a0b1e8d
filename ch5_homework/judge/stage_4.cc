/// Stage 4, one function after the other: the null space of the gauge's motions (4a, 4b), the projection (4c), the
/// motion's Jacobian (4d), and the covariance of another gauge (4e), first on matrices without structure, then on whole
/// problems, where it must be the one that is computed directly in the other gauge.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <optional>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/mistakes/stage_4.h"
#include "ch5_homework/judge/stage_4_scene.h"

namespace ch5::homework {
namespace {

using namespace stage_4;

constexpr GaugeGroup kGroups[] = {GaugeGroup::kVisualInertial, GaugeGroup::kMonocular};
constexpr double kTolerance = 1e-7;            // of numerical derivatives
constexpr double kSmallestEigenvalue = 5e-9;   // of the largest one
constexpr double kCovarianceTolerance = 1e-5;  // over 1000 seeds they are exact to 1.3e-8

// ---- the student's functions ----------------------------------------------------------------------------------------
// The given code makes matrices of the right size.

/// @param only  of this vertex alone
MatXX NullSpace(Scene& scene, GaugeGroup group, std::optional<int> only = {}) {
  const VertexList all = scene.Vertices();
  Values given{{"group", group}};
  if (only) given.Put("only", *only);
  const VertexList asked = only ? VertexList{all.at(static_cast<size_t>(*only))} : all;
  return Ask("GaugeNullSpace", scene, given).Sized("U", TotalLocalDimension(asked), NumGaugeDirections(group));
}

MatXX Projection(const MatXX& U, const MatXX& V) {
  return Ask("GaugeProjection", {{"U", U}, {"V", V}}).Sized("Q", U.rows(), U.rows());
}

MatXX MotionJacobian(Scene& scene, double yaw) {
  const int size = TotalLocalDimension(scene.Vertices());
  return Ask("GaugeMotionJacobian", scene, {{"yaw", yaw}}).Sized("motion", size, size);
}

MatXX Transformed(const MatXX& covariance, const MatXX& motion, const MatXX& Q, const MatXX& Q_C) {
  return Ask("TransformCovariance", {{"covariance", covariance}, {"motion", motion}, {"Q", Q}, {"Q_C", Q_C}})
      .Sized("transformed", covariance.rows(), covariance.cols());
}

// ---- 4a, the rows of a pose -----------------------------------------------------------------------------------------

// The blocks of a pose one by one, so that each mistake is named whatever the other blocks are.
void CheckPose(const VertexPose& pose, const MatXX& U, const MatXX& right, GaugeGroup group) {
  const PoseMistakes mistakes(pose, group);
  const Eigen::Index k = mistakes.axes.cols();
  const auto check = [&](const Text& what, const MatXX& expected, const MatXX& got, const std::string& row,
                         const Names& columns, const std::vector<Mistake>& typical) {
    Require("4", {"4.rows_pose", {{"what", what}, {"system", NameOf(group)}}}, expected, got,
            Words({row + ".x", row + ".y", row + ".z"}), typical, kTolerance, "4a", {}, columns);
  };
  const Names all = DirectionNames(group), shifts(all.begin(), all.begin() + 3),
              turns(all.begin() + 3, all.begin() + 3 + k);
  const MatXX I = MatXX::Identity(3, 3);
  check("4.shift_of_position", right.topLeftCorner(3, 3), U.topLeftCorner(3, 3), "δp", shifts,
        mistakes.InShifts(U.block(3, 0, 3, 3)));
  check("4.turn_of_position", right.block(0, 3, 3, k), U.block(0, 3, 3, k), "δp", turns,
        mistakes.InTurnsOfThePosition());
  check("4.turn_of_rotation", right.block(3, 3, 3, k), U.block(3, 3, 3, k), "δθ", turns,
        mistakes.InTurnsOfTheRotation());
  check("4.shift_of_rotation", I, I + U.block(3, 0, 3, 3), "δθ", shifts, {{"4a", "4.shift_turns_nothing", 2.0 * I}});
}

// Paper and pencil: R takes x to y, y to z and z to x; p = (2, 1, 0).
TEST(Stage4, APoseOnPaper) {
  GraphScene scene("pose on paper");
  MatXX right = MatXX::Zero(6, 4);
  right.topLeftCorner<3, 3>().setIdentity();
  right.col(3) << -1, 2, 0, 0, 1, 0;
  const MatXX U = NullSpace(scene, GaugeGroup::kVisualInertial);
  CheckPose(dynamic_cast<const VertexPose&>(*scene.vertices[0]), U, right, GaugeGroup::kVisualInertial);
}

TEST(Stage4, APoseMovesWithTheWorld) {
  for (const GaugeGroup group : kGroups) {
    GraphScene scene("vertices of a type", {0, 5, 83});
    for (size_t k = 0; k < scene.vertices.size(); ++k) {
      const auto& pose = scene.vertices[k];
      CheckPose(dynamic_cast<const VertexPose&>(*pose), NullSpace(scene, group, static_cast<int>(k)),
                NumericNullSpace({pose}, group), group);
    }
  }
}

// ---- 4b, the rows of a velocity -------------------------------------------------------------------------------------

TEST(Stage4, AVelocityTurnsAndIsNotShifted) {
  for (const GaugeGroup group : kGroups) {
    GraphScene scene("vertices of a type", {1, 5, 89});
    for (size_t vertex = 0; vertex < scene.vertices.size(); ++vertex) {
      const auto& speed = scene.vertices[vertex];
      const Eigen::Index columns = 3 + AxesOf(group).cols();
      const MatXX right = NumericNullSpace({speed}, group).topLeftCorner(3, columns);
      const MatXX got = NullSpace(scene, group, static_cast<int>(vertex)).topLeftCorner(3, columns);
      const MatXX turn = Hat(dynamic_cast<const VertexSpeedBias&>(*speed).v()) * AxesOf(group);
      const auto rows = [&](const MatXX& left, const MatXX& turns) {
        return MatXX((MatXX(3, columns) << left, turns).finished());
      };
      const MatXX O = MatXX::Zero(3, 3), I = MatXX::Identity(3, 3);
      Require("4", {"4.U_rows_velocity", {{"system", NameOf(group)}}}, right, got, Words({"δv.x", "δv.y", "δv.z"}),
              {{"4b", "4.rows_still_zero", rows(O, O.leftCols(columns - 3))},
               {"4b", {"4.sign_of_omega", {{"p", Word("v")}}}, rows(O, turn)},
               {"4b", "4.velocity_not_shifted", rows(I, -turn)},
               {"4b", "4.velocity_not_shifted_and_sign", rows(I, turn)},
               {"4b", {"4.axes_alone", {{"p", Word("v")}}}, rows(O, AxesOf(group))}},
              kTolerance, "4b", {}, DirectionNames(group));
    }
  }
}

// Whatever the number and the order of the vertices; the rows of points, biases and depths, and the scale, are given.
TEST(Stage4, TheNullSpaceIsTheDerivativeOfTheWorldsMotion) {
  for (const GaugeGroup group : kGroups) {
    for (const int count : {4, 9, 17}) {
      GraphScene scene("vertices of all types", {count, 97});
      const Vertices& vertices = scene.vertices;
      Require("4", {"4.U_of_vertices", {{"n", Word(count)}, {"system", NameOf(group)}}},
              NumericNullSpace(vertices, group), NullSpace(scene, group), RowNames(vertices), {}, kTolerance, {}, {},
              DirectionNames(group));
    }
  }
}

// ---- 4c, the projection ---------------------------------------------------------------------------------------------

void CheckProjection(const MatXX& U, const MatXX& V, const Names& names, const Text& what) {
  const MatXX I = MatXX::Identity(U.rows(), U.rows()), Vt = V.transpose(), A = Vt * U;
  const auto minus = [&](const MatXX& lost) { return MatXX(I - lost); };
  const MatXX right = ProjectionByItsEffect(U, V), lost = I - right;
  Require("4", what, right, Projection(U, V), names,
          {{"4c", "4.Q_still_identity", I},
           {"4c", "4.U_V_exchanged", right.transpose()},
           {"4c", SignAdded("U (VᵀU)⁻¹ Vᵀ"), I + lost, kOfSign},
           {"4c", "4.lost_part_itself", lost},
           {"4c", "4.identity_lost", -lost},
           {"4c", "4.UTV_inv_for_VTU_inv", minus(U * A.transpose().inverse() * Vt)},
           {"4c", "4.VTU_inv_missing", minus(U * Vt)},
           {"4c", InverseMeant("VᵀU"), minus(U * A * Vt)},
           {"4c", {"formula.inverse_twice", {{"inverse", Word("(VᵀU)⁻¹")}}}, minus(U * A.inverse() * A.inverse() * Vt)},
           {"4c", StandsFor("VᵀV", "VᵀU"), minus(U * (V.transpose() * V).inverse() * Vt)},
           {"4c", "4.V_for_U", minus(V * A.inverse() * Vt)},
           {"4c", "4.U_for_V", minus(U * A.inverse() * U.transpose())},
           {"4c", "4.V_nowhere", minus(U * (U.transpose() * U).inverse() * U.transpose())}},
          1e-9, "4c", "Q");
}

// Two scalars and their difference: U = (1, 1)ᵀ, and the first is held.
TEST(Stage4, TheProjectionOnPaper) {
  CheckProjection(Vec2(1, 1), Vec2(1, 0), Words({"x1", "x2"}), "4.Q_of_two_scalars");
}

TEST(Stage4, TheProjectionEndsInTheGaugeWhateverUAndVAre) {
  for (const int columns : {1, 2, 4, 7}) {
    Random random(Seed(101 + static_cast<uint64_t>(columns)));
    const int n = 2 * columns + 5;
    const MatXX U = RandomMatrix(n, columns, &random), V = U + RandomMatrix(n, columns, &random);
    CheckProjection(U, V, {},
                    {"4.Q_of_random_U_V", {{"size", Word(std::to_string(n) + "×" + std::to_string(columns))}}});
  }
}

TEST(Stage4, TheProjectionRemovesTheGaugesMotionsAndNothingElse) {
  for (const GaugeGroup group : kGroups) {
    const FreeScene scene(group, 3, 4, 103);
    const MatXX U = NumericNullSpace(scene.vertices, group);
    for (const bool held : {true, false}) {
      const Text gauge = held ? "4.held_first_frame" : "4.free_V_U";
      const MatXX V = held ? scene.FirstFrame(group) : U;
      CheckProjection(U, V, RowNames(scene.vertices), {"4.Q_of_gauge", {{"system", NameOf(group)}, {"gauge", gauge}}});
    }
  }
}

// ---- 4d, the Jacobian of the motion ---------------------------------------------------------------------------------

void CheckMotion(GraphScene& scene, double yaw, const Text& what) {
  const Vertices& vertices = scene.vertices;
  const Motion g{1.0, ExpSO3(Vec3(0, 0, yaw)), Vec3(1, -2, 3)};  // t must not matter
  Require("4", {"4.motion_jacobian_of", {{"scene", what}, {"n", Word(yaw)}}}, NumericMotionJacobian(vertices, g),
          MotionJacobian(scene, yaw), RowNames(vertices), MotionMistakes(vertices, g.R.toRotationMatrix()), kTolerance,
          "4d");
}

TEST(Stage4, TheMotionTurnsWhatIsExpressedInTheWorld) {
  Random random(Seed(107));
  const double yaw = random.Uniform(0.5, 2.0);
  int type = 0;
  for (const char* words : {"4.pose", "4.velocity_biases", "4.point"}) {
    GraphScene scene("vertices of a type", {type++, 1, 108});
    CheckMotion(scene, yaw, words);
  }
  for (const int count : {4, 7, 15}) {
    GraphScene scene("vertices of all types", {count, 109});
    CheckMotion(scene, -random.Uniform(0.0, 3.0), {"4.vertices", {{"n", Word(count)}}});
  }
}

// ---- 4e, the product ------------------------------------------------------------------------------------------------

TEST(Stage4, TheCovarianceIsMultipliedFromBothSides) {
  for (const int n : {3, 6, 10}) {
    Random random(Seed(109 + static_cast<uint64_t>(n)));
    const MatXX C = RandomPositiveDefinite(n, &random);
    const MatXX M = RandomMatrix(n, n, &random).householderQr().householderQ();  // orthogonal, as every ∂θ_C/∂θ is
    const MatXX U = RandomMatrix(n, n / 3, &random), V = U + RandomMatrix(n, n / 3, &random);
    const MatXX Q = ProjectionByItsEffect(U, V), Q_C = M * Q * M.transpose();  // the same gauge at θ and at θ_C
    const MatXX T = Q_C * M, Tt = T.transpose();
    const auto by = [&](const MatXX& factor) { return MatXX(factor * C * factor.transpose()); };
    const MatXX got = Transformed(C, M, Q, Q_C);
    const bool exploded = !got.allFinite() || (got.size() > 0 && got.norm() > 1e8);  // all that is given is near 1
    Require("4", {"4.covariance_of_random", {{"size", Word(std::to_string(n) + "×" + std::to_string(n))}}}, T * C * Tt,
            got, {},
            {{"4e", "4.T_has_no_inverse", exploded ? got : MatXX()},
             {"4e", "4.covariance_not_changed", C},
             {"4e", "4.result_still_zero", MatXX::Zero(n, n)},
             {"4e", "4.Q_motion_exchanged_places", by(M * Q_C)},
             {"4e", "4.Q_of_other_place", by(Q * M)},
             {"4e", "4.one_side_only", T * C},
             {"4e", "4.one_side_only", C * Tt},
             {"4e", DiagonalAlone("Cov"), T * MatXX(C.diagonal().asDiagonal()) * Tt},
             {"4e", "4.transpose_missing", T * C * T},
             {"4e", "4.transpose_missing", T * C * M.transpose() * Q_C},
             {"4e", "4.order_of_transposed", T * C * Q_C.transpose() * M.transpose()},
             {"4e", "4.transpose_wrong_side", Tt * C * T},
             {"4e", "4.Q_missing_right", T * C * M.transpose()},
             {"4e", "4.Q_missing_left", M * C * Tt},
             {"4e", "4.motion_missing_right", T * C * Q_C.transpose()},
             {"4e", "4.motion_missing", by(Q_C)},
             {"4e", "4.motion_missing", by(Q)},
             {"4e", "4.motion_missing", by(Q_C * Q)},
             {"4e", "4.Q_missing", by(M)},
             {"4e", "4.Q_transposed", by(Q_C.transpose() * M)},
             {"4e", "4.motion_transposed", by(Q_C * M.transpose())},
             {"4e", "4.motion_transposed", by(M.transpose() * Q)}},
            1e-10, "4e", "transformed");
  }
}

// The handout's example: one measurement of x2 − x1 with σ = 2.
TEST(Stage4, TheExampleOfTheHandout) {
  const Vec2 U(1, 1), V(1, 0);
  const MatXX free = (MatXX(2, 2) << 1, -1, -1, 1).finished(), fixed = (MatXX(2, 2) << 0, 0, 0, 4).finished();
  const MatXX I = MatXX::Identity(2, 2), H = 0.25 * free;
  ASSERT_TRUE(FreeCovariance(H, 1).isApprox(free) && FixedCovariance(H, V).isApprox(fixed)) << "the handout is wrong";
  Require("4", "4.handout_held", fixed, Transformed(free, I, Projection(U, V), Projection(U, V)), Words({"x1", "x2"}));
  Require("4", "4.handout_set_free", free, Transformed(fixed, I, Projection(U, U), Projection(U, U)),
          Words({"x1", "x2"}));
}

// ---- all together ---------------------------------------------------------------------------------------------------

// A scene whose covariances can be compared: none of its directions is nearly as free as the gauge.
std::unique_ptr<FreeScene> WellConditioned(GaugeGroup group, int frames, int points, int seed) {
  const int nullity = group == GaugeGroup::kVisualInertial ? 4 : 7;
  for (;; seed += 1000) {
    auto scene = std::make_unique<FreeScene>(group, frames, points, seed);
    const VecX eigenvalues = scene->Hessian().selfadjointView<Eigen::Lower>().eigenvalues();
    if (eigenvalues(nullity) > kSmallestEigenvalue * eigenvalues(eigenvalues.size() - 1)) return scene;
  }
}

// The free estimate is moved by g, so that it holds the gauge of the first frame; and back.
void CheckGauges(GaugeGroup group, int frames, int points, int seed) {
  const auto drawn = WellConditioned(group, frames, points, seed);
  FreeScene& scene = *drawn;
  const Names names = RowNames(scene.vertices);
  const auto of = [&](const Text& what) {
    return Text("4.frames", {{"what", what}, {"system", NameOf(group)}, {"n", Word(frames)}});
  };
  const MatXX H = scene.Hessian(), U = NullSpace(scene, group);
  Require("4", of("4.I_H_U"), MatXX::Ones(U.rows(), U.cols()),
          MatXX::Ones(U.rows(), U.cols()) + H * U / H.cwiseAbs().maxCoeff(), names, {}, 1e-9, {}, {},
          DirectionNames(group));
  const MatXX free = FreeCovariance(H, static_cast<int>(U.cols()));
  const MatXX Q = Projection(U, scene.FirstFrame(group)), Q_free = Projection(U, U);

  const double yaw = 0.4 + 0.1 * static_cast<double>(frames);
  MoveAll({1.0, ExpSO3(Vec3(0, 0, yaw)), Vec3(3, -2, 1)}, scene.vertices);
  const MatXX V = scene.FirstFrame(group), fixed = FixedCovariance(scene.Hessian(), V);
  const MatXX U_C = NullSpace(scene, group);
  const MatXX Q_C = Projection(U_C, V), Q_C_free = Projection(U_C, U_C);
  const MatXX motion = MotionJacobian(scene, yaw);
  ASSERT_GT((free - fixed).norm(), 0.1 * fixed.norm()) << "the scene is too easy: both gauges have one covariance";
  Require("4", of("4.covariance_held"), fixed, Transformed(free, motion, Q, Q_C), names, {}, kCovarianceTolerance);

  const MatXX back = MotionJacobian(scene, -yaw);
  Require("4", of("4.covariance_set_free"), free, Transformed(fixed, back, Q_C_free, Q_free), names, {},
          kCovarianceTolerance);
}

TEST(Stage4, FreeAndFixedCovariancesOfACameraWithAnImuAreOne) {
  CheckGauges(GaugeGroup::kVisualInertial, 4, 6, 113);
  CheckGauges(GaugeGroup::kVisualInertial, 6, 5, 127);
}

TEST(Stage4, FreeAndFixedCovariancesOfACameraAloneAreOne) {
  CheckGauges(GaugeGroup::kMonocular, 3, 8, 131);
  CheckGauges(GaugeGroup::kMonocular, 5, 6, 137);
}

}  // namespace
}  // namespace ch5::homework
