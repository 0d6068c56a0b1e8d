#include "ch5_homework/judge/right/gauge_freedom.h"

#include <cmath>

namespace ch5::homework::right {

// axes, or by mistake the yaw's alone.
static Expression AllAxes(const MatXX& axes) {
  MatXX yaw = axes;
  yaw.rightCols(axes.cols() - 1).setZero();
  return MistakenFor(Matrix("axes", axes), {{Matrix("axes", yaw), "4.yaw_alone"}});
}

PoseRows::PoseRows(const Vec3& p, const Mat33& R_given, const MatXX& axes) {
  const auto hat = [](const char* name, const Vec3& a) { return Matrix(name, Hat(a)); };
  const Expression R = Matrix("R", R_given), I = Matrix("I", MatXX::Identity(3, 3)), E = AllAxes(axes);
  const Expression Rt = Transpose(R), arm = hat("[p]", p);
  const Vec3 phi = LogSO3(Qd(R_given));

  dp_dt = {I, {R, arm}};
  std::vector<Instead> turned;
  for (const Expression& one : {R, Rt}) {
    const Text cause("4.R_stands_before_turn", {{"R", Word(NameOf(one))}});
    for (const double sign : {1.0, -1.0}) {
      for (const Expression& instead : {one * arm, arm * one, hat("[R p]", Value(one) * p)}) {
        turned.push_back({sign * instead, cause});
      }
    }
  }
  dp_domega = {-(MistakenFor(arm, turned) * E), {Matrix("p", p)}};
  dtheta_domega = {MistakenFor(Rt, {{Matrix("J_l⁻¹", RightJacobianInverseSO3(-phi)), "4.J_linv"},
                                    {Matrix("J_r⁻¹", RightJacobianInverseSO3(phi)), "4.J_rinv"},
                                    {arm, "4.turn_position"},
                                    {-arm, "4.turn_position"}}) *
                   E};
}

Formula VelocityTurned(const Vec3& v, const MatXX& axes) {
  return {-(Matrix("[v]", Hat(v)) * AllAxes(axes)), {Matrix("v", v)}};
}

Formula Projection(const MatXX& U_given, const MatXX& V_given) {
  const Expression U = Matrix("U", U_given), V = Matrix("V", V_given), Vt = Transpose(V);
  const Expression along_U = MistakenFor(U * Inverse(Vt * U) * Vt, {V * Vt, U * Transpose(U)});
  return {Matrix("I", MatXX::Identity(U_given.rows(), U_given.rows())) - along_U};
}

Formula MotionRows(const Mat33& R_given, int row, int dim, int columns) {
  const Expression R_z = Matrix("R_z", R_given), I = Matrix("I", Mat33::Identity());
  const double yaw = std::atan2(R_given(1, 0), R_given(0, 0)), degrees = yaw * 180.0 / 3.14159265358979323846;
  const auto turn = [](const char* name, const Vec3& by) { return Matrix(name, ExpSO3(by).toRotationMatrix()); };
  const std::vector<Instead> others{I,
                                    I + R_z,
                                    R_z * R_z,
                                    -R_z,
                                    Matrix("[e_z]", Hat(Vec3::UnitZ())) * R_z,
                                    Matrix("I + [(0, 0, θ)]", Mat33::Identity() + Hat(Vec3(0, 0, yaw))),
                                    turn("R_z(θ/2)", {0, 0, 0.5 * yaw}),
                                    turn("R_z(180 θ/π)", {0, 0, degrees}),
                                    turn("R_z(π θ/180)", {0, 0, yaw * yaw / degrees}),
                                    turn("R_x(θ)", {yaw, 0, 0}),
                                    turn("R_y(θ)", {0, yaw, 0})};
  std::vector<Share> shares;
  for (int k = 0; k + 3 <= dim; k += 3) {
    const std::string at = "(" + std::to_string(k) + ", " + std::to_string(k) + ")";
    const Expression x = k == 0 ? MistakenFor(R_z, others) : MistakenFor(I, {R_z});
    shares.push_back({x, {k, row + k}, {}, {{"formula.entries_of", {{"block", Word(at)}}}}});
  }
  if (dim < 3) shares.push_back({Matrix("I", MatXX::Identity(dim, dim)), {0, row}});
  return {Assembly("∂θ_C/∂θ", dim, columns, shares)};
}

Formula OfOtherGauge(const MatXX& covariance, const MatXX& motion, const MatXX& Q, const MatXX& Q_C) {
  const Expression T = Named(Matrix("Q_C", Q_C) * Matrix("∂θ_C/∂θ", motion), "(Q_C ∂θ_C/∂θ)");
  const Expression before = Matrix("Cov", covariance);
  const MatXX one = Value(T) * covariance;
  const Instead half{Matrix("½ (T Cov + (T Cov)ᵀ)", 0.5 * (one + one.transpose()))};
  return {MistakenFor(T * before * Transpose(T), {half}), {Matrix("Q", Q), before}};
}

}  // namespace ch5::homework::right
