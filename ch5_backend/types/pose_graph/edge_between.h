#pragma once
/// The edges of a pose graph: a measured transform T_z from pose i to pose j, in space and in the plane.
///
///   T_d = T_z⁻¹ (T_i⁻¹ T_j),  the identity where the poses agree with the measurement
///
///   SE(3)   r = [ p_d ; vec(q_d) ]   = [ R_zᵀ (R_iᵀ (p_j − p_i) − p_z) ; vec(q_z⁻¹ q_i⁻¹ q_j) ],   sign: w(q_d) ≥ 0
///   SE(2)   r = [ p_d ; θ_d ]        = [ R_zᵀ (R_iᵀ (p_j − p_i) − p_z) ; wrap(θ_j − θ_i − θ_z) ]
///
/// This is g2o's error, so that the information matrices of .g2o files mean what they meant when they were written,
/// and Σ rᵀWr is the χ² that g2o prints. Mind that vec(q) is *half* the rotation vector. Ceres' pose_graph examples
/// read the same files with r' = [R_z p_d; −2 R_z vec(q_d)]: r' = A r, so their cost is ours with AᵀWA for W.
/// (Source: the public g2o types slam3d and slam2d; Ceres' examples/slam.)

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/pose_graph/vertex_se2.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

class EdgeSE3Between : public SizedEdge<6, VertexPose, VertexPose> {
 public:
  /// @param q_z, p_z  the measured T_z: rotation (normalized here) and position [m] of j as seen from i
  /// W weighs [p_d; vec(q_d)], [m; half radians].
  /// @throws std::invalid_argument if q_z is zero or not finite
  EdgeSE3Between(std::shared_ptr<VertexPose> i, std::shared_ptr<VertexPose> j, const Qd& q_z, const Vec3& p_z)
      : SizedEdge(std::move(i), std::move(j)), q_z_(RotationOf(q_z, "EdgeSE3Between")), p_z_(p_z) {}

  /// W of the measurement's uncertainty: the halves of the angles are taken care of.
  /// @param covariance  of the increment [δp; δθ] of T_z, [m; rad], as VertexPose::Plus applies it: δp along i's axes
  /// @throws std::invalid_argument unless it is symmetric positive definite
  void SetCovariance(const Mat66& covariance);

  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return "EdgeSE3Between"; }

  const Qd& q_z() const { return q_z_; }
  const Vec3& p_z() const { return p_z_; }

 private:
  Qd q_z_;
  Vec3 p_z_;
};

/// The relative pose of two poses in the plane; r = [R_zᵀ(R_iᵀ(p_j − p_i) − p_z); θ_j − θ_i − θ_z], [m; rad].
class EdgeSE2Between : public SizedEdge<3, VertexSE2, VertexSE2> {
 public:
  /// @param p_z [m], theta_z [rad]  the measured pose of j as seen from i;  W weighs [m; rad], translation first
  EdgeSE2Between(std::shared_ptr<VertexSE2> i, std::shared_ptr<VertexSE2> j, const Vec2& p_z, double theta_z)
      : SizedEdge(std::move(i), std::move(j)), p_z_(p_z), theta_z_(WrapAngle(theta_z)), R_z_T_(Rotation2(-theta_z_)) {}

  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return "EdgeSE2Between"; }

  const Vec2& p_z() const { return p_z_; }
  double ThetaZ() const { return theta_z_; }

 private:
  Vec2 p_z_;
  double theta_z_;
  Mat22 R_z_T_;  // R_zᵀ
};

/// AᵀWA of the drawing above: with this information our edge has the cost of Ceres' pose_graph examples with W.
Mat66 InformationOfCeresError(const EdgeSE3Between& edge, const Mat66& W);
Mat33 InformationOfCeresError(const EdgeSE2Between& edge, const Mat33& W);

}  // namespace ch5
