#include "ch5_backend/types/pose_graph/edge_between.h"

#include "ch5_backend/math/psd.h"

namespace ch5 {
namespace {

// q_d = q_z⁻¹ q_i⁻¹ q_j of the sign with w ≥ 0: the shorter way round.
Qd Discrepancy(const Qd& q_z, const Qd& q_i, const Qd& q_j) {
  Qd q_d = q_z.conjugate() * (q_i.conjugate() * q_j);
  if (q_d.w() < 0.0) q_d.coeffs() = -q_d.coeffs();
  return q_d;
}

}  // namespace

// r ≈ −[R_zᵀ δp; ½δθ], so W = A⁻ᵀ Σ⁻¹ A⁻¹ with A = diag(R_zᵀ, ½I).
void EdgeSE3Between::SetCovariance(const Mat66& covariance) {
  Mat66 A_inverse = Mat66::Zero();
  A_inverse.topLeftCorner<3, 3>() = q_z_.toRotationMatrix();
  A_inverse.bottomRightCorner<3, 3>() = 2.0 * Mat33::Identity();
  SetInformation(A_inverse.transpose() * InverseOfCovariance(covariance, TypeInfo()) * A_inverse);
}

void EdgeSE3Between::ComputeResidual() {
  const VertexPose &i = GetVertex<0>(), &j = GetVertex<1>();
  const Vec3 p_ij = i.q().conjugate() * (j.p() - i.p());
  r_ << q_z_.conjugate() * (p_ij - p_z_), Discrepancy(q_z_, i.q(), j.q()).vec();
}

// With q_d = [w, v]:
//
//            δp_i        δθ_i                       δp_j        δθ_j
//   p_d  [ −R_zᵀR_iᵀ   R_zᵀ [R_iᵀ(p_j − p_i)]  |   R_zᵀR_iᵀ     0             ]
//   q_d  [  0          −½ (w I − [v]) R_zᵀ     |   0            ½ (w I + [v]) ]
//
// since q_i ⊗ Exp(δθ_i) turns q_d into [1, −½R_zᵀδθ_i] ⊗ q_d, and q_j ⊗ Exp(δθ_j) into q_d ⊗ [1, ½δθ_j].
void EdgeSE3Between::ComputeJacobians() {
  const VertexPose &i = GetVertex<0>(), &j = GetVertex<1>();
  const Mat33 R_z_T = q_z_.toRotationMatrix().transpose(), R_i_T = i.R().transpose();
  const Qd q_d = Discrepancy(q_z_, i.q(), j.q());
  const Mat33 half_w = 0.5 * q_d.w() * Mat33::Identity(), half_v = 0.5 * Hat(q_d.vec());

  J<1>().setZero();
  J<1>().block<3, 3>(0, 0).noalias() = R_z_T * R_i_T;
  J<1>().block<3, 3>(3, 3) = half_w + half_v;

  J<0>().setZero();
  J<0>().block<3, 3>(0, 0) = -J<1>().block<3, 3>(0, 0);
  J<0>().block<3, 3>(0, 3).noalias() = R_z_T * Hat(R_i_T * (j.p() - i.p()));
  J<0>().block<3, 3>(3, 3).noalias() = (half_v - half_w) * R_z_T;
}

void EdgeSE2Between::ComputeResidual() {
  const VertexSE2 &i = GetVertex<0>(), &j = GetVertex<1>();
  const Vec2 p_ij = Rotation2(-i.Theta()) * (j.p() - i.p());
  r_ << R_z_T_ * (p_ij - p_z_), WrapAngle(j.Theta() - i.Theta() - theta_z_);
}

//   ∂(R_iᵀ a)/∂θ_i = [y, −x]ᵀ  where  [x, y]ᵀ = R_iᵀ a
void EdgeSE2Between::ComputeJacobians() {
  const VertexSE2 &i = GetVertex<0>(), &j = GetVertex<1>();
  const Mat22 R_i_T = Rotation2(-i.Theta());
  const Vec2 p_ij = R_i_T * (j.p() - i.p());

  J<1>().setIdentity();
  J<1>().block<2, 2>(0, 0) = R_z_T_ * R_i_T;

  J<0>() = -J<1>();
  J<0>().block<2, 1>(0, 2) = R_z_T_ * Vec2(p_ij.y(), -p_ij.x());
}

Mat66 InformationOfCeresError(const EdgeSE3Between& edge, const Mat66& W) {
  Mat66 A = Mat66::Zero();
  A.topLeftCorner<3, 3>() = edge.q_z().toRotationMatrix();
  A.bottomRightCorner<3, 3>() = -2.0 * A.topLeftCorner<3, 3>();
  return A.transpose() * W * A;
}

Mat33 InformationOfCeresError(const EdgeSE2Between& edge, const Mat33& W) {
  Mat33 A = Mat33::Identity();
  A.topLeftCorner<2, 2>() = Rotation2(edge.ThetaZ());
  return A.transpose() * W * A;
}

}  // namespace ch5
