#pragma once
/// The IMU between two frames i and j (t = Δt, G = +g e_z, what a resting accelerometer feels):
///
///   r_p = R_iᵀ(½Gt² + p_j − p_i − v_i t) − α̂        α̂ = α + J_αa δb_a + J_αg δb_g
///   r_θ = 2 vec(γ̂⁻¹ q_i⁻¹ q_j)                      γ̂ = γ Exp(J_γg δb_g)
///   r_v = R_iᵀ(Gt + v_j − v_i) − β̂                  β̂ = β + J_βa δb_a + J_βg δb_g
///   r_a = b_a,j − b_a,i,   r_g = b_g,j − b_g,i       δb = b_i − (the biases of the integration)
///
/// Information: the inverse of the preintegration's covariance.  Source: VINS-Mono §IV-B, Forster 2017.

#include "ch5_backend/graph/fast_edge.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/inertial/preintegration.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

class EdgeImu : public SizedEdge<15, VertexPose, VertexSpeedBias, VertexPose, VertexSpeedBias>, public FastEdge {
 public:
  /// @param imu  from frame i to frame j, shared with the window;  @param reaction  G in W [m/s²]
  /// @throws std::invalid_argument if there is no preintegration, or its covariance is singular: of a single step, after which
  ///         position and speed err alike, or with a noise of zero
  EdgeImu(std::shared_ptr<VertexPose> T_W_Bi, std::shared_ptr<VertexSpeedBias> speed_bias_i,
          std::shared_ptr<VertexPose> T_W_Bj, std::shared_ptr<VertexSpeedBias> speed_bias_j,
          std::shared_ptr<const Preintegration> imu, const Vec3& reaction = Vec3(0, 0, 9.81));
  void ComputeResidual() override;
  void ComputeJacobians() override;
  bool NegativeProductsInto(double* C) override;
  std::string TypeInfo() const override { return "EdgeImu"; }
  /// Whether W is that of this preintegration, as it is now.
  bool IsMadeOf(const Preintegration& imu) const { return imu_.get() == &imu && imu.Revision() == revision_; }

 private:
  // What r and its Jacobians are made of.
  struct Terms {
    Vec3 phi;              // J_γg δb_g
    Mat33 R_i_T;           // R_iᵀ
    Qd gamma, Q;           // γ̂, and γ̂⁻¹ q_i⁻¹ q_j
    Vec3 position, speed;  // R_iᵀ(…) of r_p and r_v
  };
  Terms ComputeTerms() const;
  ResidualVector ResidualOf(const Terms& terms) const;
  // Calls set(vertex, row, column, block) for the 3×3 blocks of the Jacobians that are not zero.
  template <typename Set>
  void ListJacobians(const Terms& terms, const Set& set) const;

  std::shared_ptr<const Preintegration> imu_;
  Vec3 G_;
  int revision_;
};

}  // namespace ch5
