#include "ch5_backend/types/inertial/edge_imu.h"

#include <Eigen/Cholesky>
#include <stdexcept>

namespace ch5 {

EdgeImu::EdgeImu(std::shared_ptr<VertexPose> T_W_Bi, std::shared_ptr<VertexSpeedBias> speed_bias_i,
                 std::shared_ptr<VertexPose> T_W_Bj, std::shared_ptr<VertexSpeedBias> speed_bias_j,
                 std::shared_ptr<const Preintegration> imu, const Vec3& reaction)
    : SizedEdge(std::move(T_W_Bi), std::move(speed_bias_i), std::move(T_W_Bj), std::move(speed_bias_j)),
      imu_(std::move(imu)),
      G_(reaction) {
  // The covariance mixes m² with (rad/s)²: scaled to a unit diagonal, its inverse keeps all its digits.
  const Vec15 scale = imu_->Covariance().diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Mat1515> llt(scale.asDiagonal() * imu_->Covariance() * scale.asDiagonal());
  if (!scale.allFinite() || llt.info() != Eigen::Success) {
    throw std::invalid_argument("EdgeImu: the preintegration's covariance is singular (" +
                                std::to_string(imu_->Samples().size()) + " samples over " +
                                std::to_string(imu_->SumDt()) + " s)");
  }
  const Mat1515 inverse = llt.solve(Mat1515::Identity());
  SetW(scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal());
}

Vec3 EdgeImu::GyroscopeCorrection() const {
  return imu_->BiasJacobian().block<3, 3>(3, 3) * (GetVertex<1>().b_g() - imu_->BiasGyroscope());
}

void EdgeImu::ComputeResidual() {
  const VertexPose& pose_i = GetVertex<0>();
  const VertexPose& pose_j = GetVertex<2>();
  const VertexSpeedBias& sb_i = GetVertex<1>();
  const VertexSpeedBias& sb_j = GetVertex<3>();
  const double t = imu_->SumDt();
  const Eigen::Matrix<double, 9, 6> J_bias = imu_->BiasJacobian();
  Vec6 delta_b;
  delta_b << sb_i.b_a() - imu_->BiasAccelerometer(), sb_i.b_g() - imu_->BiasGyroscope();

  const Qd q_i_inverse = pose_i.q().conjugate();
  const Qd gamma = imu_->Gamma() * ExpSO3(GyroscopeCorrection());
  const Vec3 alpha = imu_->Alpha() + J_bias.topRows<3>() * delta_b;
  const Vec3 beta = imu_->Beta() + J_bias.bottomRows<3>() * delta_b;
  r_ << q_i_inverse * (0.5 * t * t * G_ + pose_j.p() - pose_i.p() - t * sb_i.v()) - alpha,
      2.0 * (gamma.conjugate() * q_i_inverse * pose_j.q()).vec(),  //
      q_i_inverse * (t * G_ + sb_j.v() - sb_i.v()) - beta,         //
      sb_j.b_a() - sb_i.b_a(), sb_j.b_g() - sb_i.b_g();
}

void EdgeImu::ComputeJacobians() {
  const VertexPose& pose_i = GetVertex<0>();
  const VertexPose& pose_j = GetVertex<2>();
  const VertexSpeedBias& sb_i = GetVertex<1>();
  const VertexSpeedBias& sb_j = GetVertex<3>();
  const double t = imu_->SumDt();
  const Mat33 I = Mat33::Identity();
  const Mat33 R_i_T = pose_i.R().transpose();
  const Eigen::Matrix<double, 9, 6> J_bias = imu_->BiasJacobian();

  // Q = γ̂⁻¹ q_i⁻¹ q_j;  2 vec(Q ⊗ [1, ½δ]) = 2 vec Q + (Q_w I + [Q_v]) δ,  and from the left with −[Q_v].
  const Vec3 phi = GyroscopeCorrection();
  const Qd gamma = imu_->Gamma() * ExpSO3(phi);
  const Qd Q = gamma.conjugate() * pose_i.q().conjugate() * pose_j.q();
  const Mat33 right = Q.w() * I + Hat(Q.vec());
  const Mat33 left = Q.w() * I - Hat(Q.vec());

  auto& J_pose_i = J<0>();
  J_pose_i.setZero();
  J_pose_i.block<3, 3>(0, 0) = -R_i_T;
  J_pose_i.block<3, 3>(0, 3) = Hat(R_i_T * (0.5 * t * t * G_ + pose_j.p() - pose_i.p() - t * sb_i.v()));
  J_pose_i.block<3, 3>(3, 3) = -left * gamma.toRotationMatrix().transpose();
  J_pose_i.block<3, 3>(6, 3) = Hat(R_i_T * (t * G_ + sb_j.v() - sb_i.v()));

  auto& J_speed_bias_i = J<1>();
  J_speed_bias_i.setZero();
  J_speed_bias_i.block<3, 3>(0, 0) = -t * R_i_T;
  J_speed_bias_i.block<3, 3>(6, 0) = -R_i_T;
  J_speed_bias_i.block<3, 6>(0, 3) = -J_bias.topRows<3>();
  J_speed_bias_i.block<3, 6>(6, 3) = -J_bias.bottomRows<3>();
  J_speed_bias_i.block<3, 3>(3, 6) = -left * RightJacobianSO3(phi) * J_bias.block<3, 3>(3, 3);
  J_speed_bias_i.bottomRightCorner<6, 6>() = -Mat66::Identity();

  J<2>().setZero();
  J<2>().block<3, 3>(0, 0) = R_i_T;
  J<2>().block<3, 3>(3, 3) = right;

  J<3>().setZero();
  J<3>().block<3, 3>(6, 0) = R_i_T;
  J<3>().bottomRightCorner<6, 6>().setIdentity();
}

}  // namespace ch5
