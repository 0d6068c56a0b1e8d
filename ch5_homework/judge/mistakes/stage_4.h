#pragma once
/// What typical mistakes in the rows of a pose (4a) and in the motion's Jacobian (4d) give.

#include <string>
#include <vector>

#include "ch5_homework/judge/mistakes/formula.h"
#include "ch5_homework/judge/stage_4_scene.h"

namespace ch5::homework::stage_4 {

/// For the blocks of a pose's rows.
struct PoseMistakes {
  MatXX axes, turn, hat, R, Rt, O;
  Vec3 phi;

  PoseMistakes(const VertexPose& pose, GaugeGroup group)
      : axes(AxesOf(group)),
        turn(Hat(pose.p()) * axes),
        hat(Hat(pose.p())),
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
    std::vector<Mistake> mistakes{{"4a", "4.block_still_zero", O},
                                  {"4a", {"4.sign_of_omega", {{"p", Word("p")}}}, turn},
                                  {"4a", {"4.axes_alone", {{"p", Word("p")}}}, axes}};
    for (const double sign : {-1.0, 1.0}) {  // with the wrong one, that is told when R has gone
      for (const auto& [name, rotation] : {std::pair{"R", R}, {"Rᵀ", Rt}}) {
        const Text cause("4.R_stands_before_turn", {{"R", Word(std::string(name))}});
        mistakes.push_back({"4a", cause, sign * rotation * turn});
        mistakes.push_back({"4a", cause, sign * hat * rotation * axes});
        mistakes.push_back({"4a", cause, sign * rotation * hat * rotation.transpose() * axes});
      }
    }
    return mistakes;
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

/// R_z of each vertex in the first columns or rows, where `row` stands once in block(…).
inline MatXX OffTheDiagonal(const Vertices& vertices, const Mat33& R_z, bool columns) {
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
inline std::vector<Mistake> MotionMistakes(const Vertices& vertices, const Mat33& R_z) {
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

}  // namespace ch5::homework::stage_4
