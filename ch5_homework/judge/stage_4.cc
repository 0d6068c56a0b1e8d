/// Stage 4, one function after the other: the null space of the gauge's motions (4a, 4b), the projection (4c) and the
/// motion's Jacobian (4d). stage_4_covariance.cc has the covariance (4e) and the whole.

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "ch5_homework/judge/mistakes/formula.h"
#include "ch5_homework/judge/stage_4_scene.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

constexpr GaugeGroup kGroups[] = {GaugeGroup::kVisualInertial, GaugeGroup::kMonocular};
constexpr double kTolerance = 1e-7;  // of numerical derivatives

// ---- 4a, the rows of a pose -----------------------------------------------------------------------------------------

// What typical mistakes give for the blocks of a pose's rows.
struct PoseMistakes {
  MatXX axes, turn, in_the_body, R, Rt, O;
  Vec3 phi;

  PoseMistakes(const VertexPose& pose, GaugeGroup group)
      : axes(AxesOf(group)),
        turn(Hat(pose.p()) * axes),
        in_the_body(-Hat(pose.p()) * pose.R().transpose() * axes),
        R(pose.R()),
        Rt(R.transpose()),
        O(MatXX::Zero(3, axes.cols())),
        phi(LogSO3(pose.q())) {}

  std::vector<Mistake> InShifts(const MatXX& of_rotation) const {
    const bool below = of_rotation.isIdentity();
    return {{"4a", below ? "4.rows_exchanged" : "4.block_still_zero", MatXX::Zero(3, 3)},
            {"4a", {"4.R_stands", {{"R", Word("R")}}}, R},
            {"4a", {"4.R_stands", {{"R", Word("Rᵀ")}}}, Rt}};
  }
  std::vector<Mistake> InTurnsOfThePosition() const {
    return {{"4a", "4.block_still_zero", O},
            {"4a", {"4.sign_of_omega", {{"p", Word("p")}}}, turn},
            {"4a", {"4.R_stands_before_turn", {{"R", Word("R")}}}, -R * turn},
            {"4a", {"4.R_stands_before_turn", {{"R", Word("Rᵀ")}}}, -Rt * turn},
            {"4a", {"4.R_stands_before_turn", {{"R", Word("Rᵀ")}}}, in_the_body},
            {"4a", {"4.axes_alone", {{"p", Word("p")}}}, axes}};
  }
  std::vector<Mistake> InTurnsOfTheRotation() const {
    return {{"4a", "4.block_still_zero", O},
            {"4a", "4.left_perturbation", axes},
            {"4a", "4.R_for_RT", R * axes},
            {"4a", "4.sign_of_RT_omega", -Rt * axes},
            {"4a", "4.J_linv", RightJacobianInverseSO3(-phi) * axes},
            {"4a", "4.J_rinv", RightJacobianInverseSO3(phi) * axes},
            {"4a", "4.turn_position", -turn}};
  }
};

// The blocks of a pose, so that each mistake is told whatever the other blocks are.
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
  const GraphScene scene("pose on paper");
  MatXX right = MatXX::Zero(6, 4);
  right.topLeftCorner<3, 3>().setIdentity();
  right.col(3) << -1, 2, 0, 0, 1, 0;
  const MatXX U = Chosen().gauge_freedom.null_space(scene.vertices, GaugeGroup::kVisualInertial);
  CheckPose(dynamic_cast<const VertexPose&>(*scene.vertices[0]), U, right, GaugeGroup::kVisualInertial);
}

TEST(Stage4, APoseMovesWithTheWorld) {
  for (const GaugeGroup group : kGroups) {
    const GraphScene scene("vertices of a type", {0, 5, 83});
    for (const auto& pose : scene.vertices) {
      CheckPose(dynamic_cast<const VertexPose&>(*pose), Chosen().gauge_freedom.null_space({pose}, group),
                NumericNullSpace({pose}, group), group);
    }
  }
}

// ---- 4b, the rows of a velocity -------------------------------------------------------------------------------------

TEST(Stage4, AVelocityTurnsAndIsNotShifted) {
  for (const GaugeGroup group : kGroups) {
    const GraphScene scene("vertices of a type", {1, 5, 89});
    for (const auto& speed : scene.vertices) {
      const Eigen::Index columns = 3 + AxesOf(group).cols();
      const MatXX right = NumericNullSpace({speed}, group).topLeftCorner(3, columns);
      const MatXX got = Chosen().gauge_freedom.null_space({speed}, group).topLeftCorner(3, columns);
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
      const GraphScene scene("vertices of all types", {count, 97});
      const Vertices& vertices = scene.vertices;
      Require("4", {"4.U_of_vertices", {{"n", Word(count)}, {"system", NameOf(group)}}},
              NumericNullSpace(vertices, group), Chosen().gauge_freedom.null_space(vertices, group), RowNames(vertices),
              {}, kTolerance, {}, {}, DirectionNames(group));
    }
  }
}

// ---- 4c, the projection ---------------------------------------------------------------------------------------------

void CheckProjection(const MatXX& U, const MatXX& V, const Names& names, const Text& what) {
  const MatXX I = MatXX::Identity(U.rows(), U.rows()), Vt = V.transpose(), A = Vt * U;
  const auto minus = [&](const MatXX& lost) { return MatXX(I - lost); };
  const MatXX right = ProjectionByItsEffect(U, V), lost = I - right;
  Require("4", what, right, Chosen().gauge_freedom.projection(U, V), names,
          {{"4c", "4.Q_still_identity", I},
           {"4c", "4.U_V_exchanged", right.transpose()},
           {"4c", SignAdded("U (VᵀU)⁻¹ Vᵀ"), I + lost},
           {"4c", "4.lost_part_itself", lost},
           {"4c", "4.identity_lost", -lost},
           {"4c", "4.UTV_inv_for_VTU_inv", minus(U * A.transpose().inverse() * Vt)},
           {"4c", "4.VTU_inv_missing", minus(U * Vt)},
           {"4c", InverseMeant("VᵀU"), minus(U * A * Vt)},
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

/// R_z of each vertex in the first columns or rows, where `row` stands once in block(…).
MatXX OffTheDiagonal(const Vertices& vertices, const Mat33& R_z, bool columns) {
  const int n = TotalLocalDimension(vertices);
  MatXX J = MatXX::Identity(n, n);
  int row = 0;
  for (const auto& vertex : vertices) {
    if (vertex->TypeInfo() != "VertexInverseDepth") J.block<3, 3>(columns ? row : 0, columns ? 0 : row) = R_z;
    row += vertex->LocalDimension();
  }
  return J;
}

/// Of one vertex, or of several.
std::vector<Mistake> MotionMistakes(const Vertices& vertices, const Mat33& R_z) {
  const int n = TotalLocalDimension(vertices);
  const MatXX I = MatXX::Identity(3, 3), O = MatXX::Zero(3, 3);
  // Of one vertex alone.
  const auto blocks = [n](const MatXX& first, const MatXX& second, const MatXX& third = MatXX::Identity(3, 3)) {
    MatXX J = MatXX::Identity(n, n);
    J.topLeftCorner(3, 3) = first;
    if (n >= 6) J.block(3, 3, 3, 3) = second;
    if (n >= 9) J.block(6, 6, 3, 3) = third;
    return MatXX(J);
  };
  std::vector<Mistake> mistakes = {{"4d", "4.motion_still_identity", MatXX::Identity(n, n)}};
  if (vertices.size() == 1) {
    mistakes.push_back({"4d", "4.motions_block_zero", blocks(O, I)});
    mistakes.push_back({"4d", "4.R_zT_for_R_z", blocks(R_z.transpose(), I)});
    const bool is_pose = n == 6;
    const Text second = is_pose ? "4.R_z_acts_dtheta" : "4.R_z_acts_bias";
    mistakes.push_back({"4d", second, blocks(R_z, R_z)});
    if (!is_pose) mistakes.push_back({"4d", second, blocks(R_z, R_z, R_z)});
    mistakes.push_back({"4d", "4.added_to_identity", blocks(I + R_z, I)});
    mistakes.push_back({"4d", "4.R_z_acts_both_sides", blocks(R_z * R_z, I)});
    mistakes.push_back({"4d", "4.sign_R_z_itself", blocks(-R_z, I)});
    mistakes.push_back({"4d", "4.R_z_in_second_rows", blocks(I, R_z)});
  } else {
    mistakes.push_back({"4d", "4.only_first_vertex_turns", blocks(R_z, I)});
    mistakes.push_back({"4d", "4.only_first_vertex_turns", blocks(R_z, R_z)});
    mistakes.push_back({"4d", "4.row_once_in_block", OffTheDiagonal(vertices, R_z, true)});
    mistakes.push_back({"4d", "4.row_once_in_block", OffTheDiagonal(vertices, R_z, false)});
  }
  return mistakes;
}

void CheckMotion(const Vertices& vertices, double yaw, const Text& scene) {
  const Motion g{1.0, ExpSO3(Vec3(0, 0, yaw)), Vec3(1, -2, 3)};  // t must not matter
  Require("4", {"4.motion_jacobian_of", {{"scene", scene}, {"n", Word(yaw)}}}, NumericMotionJacobian(vertices, g),
          Chosen().gauge_freedom.motion_jacobian(vertices, yaw), RowNames(vertices),
          MotionMistakes(vertices, g.R.toRotationMatrix()), kTolerance, "4d");
}

TEST(Stage4, TheMotionTurnsWhatIsExpressedInTheWorld) {
  Random random(Seed(107));
  const double yaw = random.Uniform(0.5, 2.0);
  int type = 0;
  for (const char* words : {"4.pose", "4.velocity_biases", "4.point"}) {
    const GraphScene scene("vertices of a type", {type++, 1, 108});
    CheckMotion(scene.vertices, yaw, words);
  }
  for (const int count : {4, 7, 15}) {
    const GraphScene scene("vertices of all types", {count, 109});
    CheckMotion(scene.vertices, -random.Uniform(0.0, 3.0), {"4.vertices", {{"n", Word(count)}}});
  }
}

}  // namespace
}  // namespace ch5::homework
