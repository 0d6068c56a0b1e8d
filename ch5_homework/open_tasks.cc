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
  // next.accepted = ?;
  // next.lambda = ?;
  // next.nu = ?;
  throw HomeworkMissing("8a UpdateDamping");
  return next;
}

// Stage 8b: a camera

ProjectionJacobians LinearizeProjection(const Transform& T_W_B, const Transform& T_B_C, const Vec3& p_W) {
  ProjectionJacobians J;
  const Mat33 R_W_B = T_W_B.q.toRotationMatrix(), R_B_C = T_B_C.q.toRotationMatrix();
  const Vec3 p_B = R_W_B.transpose() * (p_W - T_W_B.p);
  const Vec3 p_C = R_B_C.transpose() * (p_B - T_B_C.p);
  // TODO:: home work 8b. ∂r/∂p_C by hand, then the chain to p_W, to δp and to δθ.
  // J.point = ?;
  // J.pose.leftCols<3>() = ?;
  // J.pose.rightCols<3>() = ?;
  throw HomeworkMissing("8b LinearizeProjection");
  return J;
}

// Stage 8c: an IMU

ImuIncrement IntegrateImu(const ImuIncrement& before, const Vec3& acceleration, const Vec3& gyroscope, double dt,
                          double sigma_a, double sigma_g) {
  ImuIncrement after;
  // TODO:: home work 8c. p, q and v after dt; then their covariance, A P Aᵀ + B Q Bᵀ with Q of the noise during dt.
  // after.p = ?;
  // after.q = ?;
  // after.v = ?;
  // after.covariance = ?;
  throw HomeworkMissing("8c IntegrateImu");
  return after;
}

// Stage 8d: a beacon

RangeTerm LinearizeRange(const Transform& T_W_B, const Vec3& antenna, const Vec3& beacon, double range) {
  RangeTerm term;
  // TODO:: home work 8d. The residual, and its derivatives by δp and δθ.
  // term.residual = ?;
  // term.J.leftCols<3>() = ?;
  // term.J.rightCols<3>() = ?;
  throw HomeworkMissing("8d LinearizeRange");
  return term;
}

}  // namespace ch5
