// Homework of chapter 5, stage 8: open tasks.  Handout: ch5_homework/handout/stage_8.md, .zh.md.
#include "ch5_backend/open_tasks/open_tasks.h"

#include <algorithm>
#include <cmath>

#include "ch5_backend/homework_missing.h"
#include "ch5_backend/math/so3.h"

namespace ch5 {

// ---- Stage 8:  pieces that the other stages use ready-made --------------------------------------------------------

// Stage 8a: accept, or go back

DampingUpdate UpdateDamping(double cost, double trial_cost, double predicted_decrease, double lambda, double nu) {
  DampingUpdate next;
  // TODO:: home work 8a. The gain ratio, whether the step is kept, and Nielsen's λ and ν for the next trial.
  // BEGIN SOLUTION 8a UpdateDamping
  const double gain_ratio = (cost - trial_cost) / predicted_decrease;
  next.accepted = trial_cost < cost && gain_ratio > 0.0;  // false with a NaN
  if (next.accepted) {
    next.lambda = lambda * std::clamp(1.0 - std::pow(2.0 * gain_ratio - 1.0, 3), 1.0 / 3.0, 2.0 / 3.0);
    next.nu = 2.0;
  } else {
    next.lambda = lambda * nu;
    next.nu = 2.0 * nu;
  }
  // BLANK
  // next.accepted = ?;
  // next.lambda = ?;
  // next.nu = ?;
  // END SOLUTION
  return next;
}

// Stage 8b: a camera

ProjectionJacobians LinearizeProjection(const Transform& T_W_B, const Transform& T_B_C, const Vec3& p_W) {
  ProjectionJacobians J;
  const Mat33 R_W_B = T_W_B.q.toRotationMatrix(), R_B_C = T_B_C.q.toRotationMatrix();
  const Vec3 p_B = R_W_B.transpose() * (p_W - T_W_B.p);
  const Vec3 p_C = R_B_C.transpose() * (p_B - T_B_C.p);
  // TODO:: home work 8b. ∂r/∂p_C by hand, then the chain to p_W, to δp and to δθ.
  // BEGIN SOLUTION 8b LinearizeProjection
  const double inverse_z = 1.0 / p_C.z();
  Mat23 dr_dp_C;
  dr_dp_C << inverse_z, 0.0, -p_C.x() * inverse_z * inverse_z, 0.0, inverse_z, -p_C.y() * inverse_z * inverse_z;
  const Mat23 dr_dp_B = dr_dp_C * R_B_C.transpose();
  J.point = dr_dp_B * R_W_B.transpose();
  J.pose << -J.point, dr_dp_B * Hat(p_B);
  // BLANK
  // J.point = ?;
  // J.pose.leftCols<3>() = ?;
  // J.pose.rightCols<3>() = ?;
  // END SOLUTION
  return J;
}

// Stage 8c: an IMU

ImuIncrement IntegrateImu(const ImuIncrement& before, const Vec3& acceleration, const Vec3& gyroscope, double dt,
                          double sigma_a, double sigma_g) {
  ImuIncrement after;
  // TODO:: home work 8c. p, q and v after dt; then their covariance, A P Aᵀ + B Q Bᵀ with Q of the noise during dt.
  // BEGIN SOLUTION 8c IntegrateImu
  const Mat33 R = before.q.toRotationMatrix(), I = Mat33::Identity();
  const Vec3 a = R * acceleration, turn = gyroscope * dt;
  after.p = before.p + before.v * dt + 0.5 * dt * dt * a;
  after.q = (before.q * ExpSO3(turn)).normalized();
  after.v = before.v + a * dt;

  Eigen::Matrix<double, 9, 9> A = Eigen::Matrix<double, 9, 9>::Identity();
  A.block<3, 3>(0, 3) = -0.5 * dt * dt * R * Hat(acceleration);
  A.block<3, 3>(0, 6) = dt * I;
  A.block<3, 3>(3, 3) = ExpSO3(-turn).toRotationMatrix();
  A.block<3, 3>(6, 3) = -dt * R * Hat(acceleration);
  Eigen::Matrix<double, 9, 6> B = Eigen::Matrix<double, 9, 6>::Zero();
  B.block<3, 3>(0, 0) = 0.5 * dt * dt * R;
  B.block<3, 3>(3, 3) = dt * RightJacobianSO3(turn);
  B.block<3, 3>(6, 0) = dt * R;
  Vec6 Q;  // a density over dt
  Q << Vec3::Constant(sigma_a * sigma_a / dt), Vec3::Constant(sigma_g * sigma_g / dt);
  after.covariance = A * before.covariance * A.transpose() + B * Q.asDiagonal() * B.transpose();
  // BLANK
  // after.p = ?;
  // after.q = ?;
  // after.v = ?;
  // after.covariance = ?;
  // END SOLUTION
  return after;
}

// Stage 8d: a beacon

RangeTerm LinearizeRange(const Transform& T_W_B, const Vec3& antenna, const Vec3& beacon, double range) {
  RangeTerm term;
  // TODO:: home work 8d. The residual, and its derivatives by δp and δθ.
  // BEGIN SOLUTION 8d LinearizeRange
  const Vec3 from_beacon = T_W_B.p + T_W_B.q * antenna - beacon;
  const Vec3 u = from_beacon.normalized();
  term.residual = from_beacon.norm() - range;
  term.J << u.transpose(), -u.transpose() * T_W_B.q.toRotationMatrix() * Hat(antenna);
  // BLANK
  // term.residual = ?;
  // term.J.leftCols<3>() = ?;
  // term.J.rightCols<3>() = ?;
  // END SOLUTION
  return term;
}

}  // namespace ch5
