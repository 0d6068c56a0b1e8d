#include "ch5_backend/types/inertial/edge_imu.h"

#include <Eigen/Cholesky>
#include <stdexcept>

#include "ch5_backend/math/row_products.h"

namespace ch5 {
namespace {

constexpr int kRows = EdgeImu::kResidualDimension;

}  // namespace

EdgeImu::EdgeImu(std::shared_ptr<VertexPose> T_W_Bi, std::shared_ptr<VertexSpeedBias> speed_bias_i,
                 std::shared_ptr<VertexPose> T_W_Bj, std::shared_ptr<VertexSpeedBias> speed_bias_j,
                 std::shared_ptr<const Preintegration> imu, const Vec3& reaction)
    : SizedEdge(std::move(T_W_Bi), std::move(speed_bias_i), std::move(T_W_Bj), std::move(speed_bias_j)),
      imu_(std::move(imu)),
      G_(reaction) {
  if (!imu_) throw std::invalid_argument("EdgeImu: the preintegration is null");
  revision_ = imu_->Revision();
  // The covariance mixes m² with (rad/s)²: scaled to a unit diagonal, its inverse keeps all its digits.
  const Vec15 scale = imu_->Covariance().diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Mat1515> llt(scale.asDiagonal() * imu_->Covariance() * scale.asDiagonal());
  constexpr double kRounding = 1e-14;  // a pivot below it is one of rounding alone; those of ten seconds are above 1e-3
  const bool is_definite =
      llt.info() == Eigen::Success && llt.matrixLLT().diagonal().cwiseAbs2().minCoeff() > kRounding;
  if (!scale.allFinite() || !is_definite) {
    throw std::invalid_argument("EdgeImu: the preintegration's covariance is singular (" +
                                std::to_string(imu_->Samples().size()) + " samples over " +
                                std::to_string(imu_->SumDt()) + " s): it takes three samples, and noises above zero");
  }
  const Mat1515 inverse = llt.solve(Mat1515::Identity());
  SetW(scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal());
}

CH5_FLATTEN EdgeImu::Terms EdgeImu::ComputeTerms() const {
  const VertexPose &pose_i = GetVertex<0>(), &pose_j = GetVertex<2>();
  const VertexSpeedBias &sb_i = GetVertex<1>(), &sb_j = GetVertex<3>();
  const double t = imu_->SumDt();
  Terms terms;
  terms.phi = imu_->BiasJacobian().block<3, 3>(3, 3) * (sb_i.b_g() - imu_->BiasGyroscope());
  terms.R_i_T = pose_i.R().transpose();
  terms.gamma = imu_->Gamma() * ExpSO3(terms.phi);
  terms.Q = terms.gamma.conjugate() * pose_i.q().conjugate() * pose_j.q();
  terms.position = terms.R_i_T * (0.5 * t * t * G_ + pose_j.p() - pose_i.p() - t * sb_i.v());
  terms.speed = terms.R_i_T * (t * G_ + sb_j.v() - sb_i.v());
  return terms;
}

CH5_FLATTEN EdgeImu::ResidualVector EdgeImu::ResidualOf(const Terms& terms) const {
  const VertexSpeedBias &sb_i = GetVertex<1>(), &sb_j = GetVertex<3>();
  const Vec3 delta_a = sb_i.b_a() - imu_->BiasAccelerometer(), delta_g = sb_i.b_g() - imu_->BiasGyroscope();
  const auto& J = imu_->BiasJacobian();
  ResidualVector r;
  r.segment<3>(0) = terms.position - imu_->Alpha() - J.block<3, 3>(0, 0) * delta_a - J.block<3, 3>(0, 3) * delta_g;
  r.segment<3>(3) = 2.0 * terms.Q.vec();
  r.segment<3>(6) = terms.speed - imu_->Beta() - J.block<3, 3>(6, 0) * delta_a - J.block<3, 3>(6, 3) * delta_g;
  r.segment<3>(9) = sb_j.b_a() - sb_i.b_a();
  r.segment<3>(12) = sb_j.b_g() - sb_i.b_g();
  return r;
}

// With Q = γ̂⁻¹ q_i⁻¹ q_j:  2 vec(Q ⊗ [1, ½δ]) = 2 vec Q + (Q_w I + [Q_v]) δ,  and from the left with −[Q_v].
template <typename Set>
void EdgeImu::ListJacobians(const Terms& terms, const Set& set) const {
  constexpr int kPoseI = 0, kSpeedBiasI = 1, kPoseJ = 2, kSpeedBiasJ = 3;
  const Mat33 I = Mat33::Identity(), &R_i_T = terms.R_i_T;
  const Mat33 right = terms.Q.w() * I + Hat(terms.Q.vec()), left = terms.Q.w() * I - Hat(terms.Q.vec());
  const auto& J = imu_->BiasJacobian();

  set(kPoseI, 0, 0, -R_i_T);
  set(kPoseI, 0, 3, Hat(terms.position));
  set(kPoseI, 3, 3, -left * terms.gamma.toRotationMatrix().transpose());
  set(kPoseI, 6, 3, Hat(terms.speed));

  set(kSpeedBiasI, 0, 0, -imu_->SumDt() * R_i_T);
  set(kSpeedBiasI, 6, 0, -R_i_T);
  set(kSpeedBiasI, 0, 3, -J.block<3, 3>(0, 0));
  set(kSpeedBiasI, 6, 3, -J.block<3, 3>(6, 0));
  set(kSpeedBiasI, 9, 3, -I);
  set(kSpeedBiasI, 0, 6, -J.block<3, 3>(0, 3));
  set(kSpeedBiasI, 3, 6, -left * RightJacobianSO3(terms.phi) * J.block<3, 3>(3, 3));
  set(kSpeedBiasI, 6, 6, -J.block<3, 3>(6, 3));
  set(kSpeedBiasI, 12, 6, -I);

  set(kPoseJ, 0, 0, R_i_T);
  set(kPoseJ, 3, 3, right);

  set(kSpeedBiasJ, 6, 0, R_i_T);
  set(kSpeedBiasJ, 9, 3, I);
  set(kSpeedBiasJ, 12, 6, I);
}

void EdgeImu::ComputeResidual() { r_ = ResidualOf(ComputeTerms()); }

CH5_FLATTEN void EdgeImu::ComputeJacobians() {
  J<0>().setZero();
  J<1>().setZero();
  J<2>().setZero();
  J<3>().setZero();
  ListJacobians(ComputeTerms(), [&](int vertex, int row, int column, const Mat33& block) {
    Eigen::Map<Mat33, 0, Eigen::OuterStride<kRows>>(jacobians_[vertex] + column * kRows + row) = block;
  });
}

// Most of J is zero, and is skipped.
CH5_FLATTEN bool EdgeImu::NegativeProductsInto(double* C) {
  if (GetLossFunction()) return false;
  constexpr int kColumnOf[] = {0, 6, 15, 21}, kColumns = 31, kStride = kernels::RowStride(kColumns);
  alignas(64) double J_r[kRows * kStride] = {}, W_J_r[kRows * kStride];
  const Terms terms = ComputeTerms();
  r_ = ResidualOf(terms);
  ListJacobians(terms, [&](int vertex, int row, int column, const Mat33& block) {
    double* to = J_r + row * kStride + kColumnOf[vertex] + column;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) to[r * kStride + c] = block(r, c);
    }
  });
  for (int i = 0; i < kRows; ++i) J_r[i * kStride + kColumns - 1] = r_[i];
  kernels::MultiplyRows(kRows, kColumns, W().data(), J_r, W_J_r);
  kernels::NegativeProducts(kRows, kColumns, J_r, W_J_r, C);
  return true;
}

}  // namespace ch5
