#include "ch5_backend/types/visual/edge_reprojection.h"

#include "ch5_backend/math/simd.h"

namespace ch5 {

// ---- inverse depth, extrinsic constant -------------------------------------------------------------------------

EdgeReprojection::EdgeReprojection(std::shared_ptr<VertexInverseDepth> inverse_depth,
                                   std::shared_ptr<VertexPose> T_W_Bi, std::shared_ptr<VertexPose> T_W_Bj,
                                   const Vec2& u_host, const Vec2& u_target, const Transform& T_B_C)
    : SizedEdge(std::move(inverse_depth), std::move(T_W_Bi), std::move(T_W_Bj)),
      f_host_(u_host.homogeneous()),
      u_target_(u_target),
      T_B_C_(T_B_C) {}

CH5_FLATTEN PointTransfer EdgeReprojection::ToTarget() const {
  const double lambda = GetVertex<0>().InverseDepth();
  return {f_host_, lambda, RigidMatrix(GetVertex<1>()), RigidMatrix(GetVertex<2>()), T_B_C_, T_B_C_};
}

// r = π(T_C_B T_Bj_W T_W_Bi T_B_C f/λ) − u.  Qin (2018), on the plane z = 1
CH5_FLATTEN void EdgeReprojection::ComputeResidual() { r_ = Project(ToTarget().p_Cj) - u_target_; }

bool EdgeReprojection::InDomain() const { return GetVertex<0>().InverseDepth() > 0.0 && ToTarget().p_Cj.z() > 0.0; }

CH5_FLATTEN void EdgeReprojection::Linearize() {
  const PointTransfer transfer = ToTarget();
  r_ = Project(transfer.p_Cj) - u_target_;
  const TransferJacobians d(transfer, GetVertex<0>().InverseDepth(), T_B_C_);
  J<0>() = d.inverse_depth;
  J<1>() = d.pose_i;
  J<2>() = d.pose_j;
}

// ---- inverse depth, extrinsic estimated ------------------------------------------------------------------------

EdgeReprojectionExtrinsic::EdgeReprojectionExtrinsic(std::shared_ptr<VertexInverseDepth> inverse_depth,
                                                     std::shared_ptr<VertexPose> T_W_Bi,
                                                     std::shared_ptr<VertexPose> T_W_Bj,
                                                     std::shared_ptr<VertexPose> T_B_C, const Vec2& u_host,
                                                     const Vec2& u_target)
    : SizedEdge(std::move(inverse_depth), std::move(T_W_Bi), std::move(T_W_Bj), std::move(T_B_C)),
      f_host_(u_host.homogeneous()),
      u_target_(u_target) {}

PointTransfer EdgeReprojectionExtrinsic::ToTarget(const RigidMatrix& T_B_C) const {
  const double lambda = GetVertex<0>().InverseDepth();
  return {f_host_, lambda, RigidMatrix(GetVertex<1>()), RigidMatrix(GetVertex<2>()), T_B_C, T_B_C};
}

void EdgeReprojectionExtrinsic::ComputeResidual() {
  r_ = Project(ToTarget(RigidMatrix(GetVertex<3>())).p_Cj) - u_target_;
}

bool EdgeReprojectionExtrinsic::InDomain() const {
  return GetVertex<0>().InverseDepth() > 0.0 && ToTarget(RigidMatrix(GetVertex<3>())).p_Cj.z() > 0.0;
}

void EdgeReprojectionExtrinsic::ComputeJacobians() {
  const RigidMatrix T_B_C(GetVertex<3>());
  const PointTransfer transfer = ToTarget(T_B_C);
  const TransferJacobians d(transfer, GetVertex<0>().InverseDepth(), T_B_C);
  J<0>() = d.inverse_depth;
  J<1>() = d.pose_i;
  J<2>() = d.pose_j;
  J<3>() = d.CameraOfHost(transfer, T_B_C) + d.CameraOfTarget(transfer);
}

// ---- 3-D point -------------------------------------------------------------------------------------------------

namespace {

// A point of the world on the body and in its camera.
struct PointInCamera {
  Mat33 R_W_B;
  Vec3 p_B, p_C;

  PointInCamera(const RigidMatrix& T_W_B, const RigidMatrix& T_B_C, const Vec3& p_W)
      : R_W_B(T_W_B.R), p_B(T_W_B.Inverse(p_W)), p_C(T_B_C.Inverse(p_B)) {}
};

// By p_W and by the pose:  ∂p_B/∂p_W = R_W_Bᵀ,  ∂p_B/∂θ = [p_B].
struct PointInCameraJacobians {
  Mat23 dr_dp_W;
  Mat26 pose;

  PointInCameraJacobians(const PointInCamera& x, const RigidMatrix& T_B_C) {
    const Mat23 dr_dp_B = ProjectionJacobian(x.p_C) * T_B_C.R.transpose();
    dr_dp_W = dr_dp_B * x.R_W_B.transpose();
    pose << -dr_dp_W, RowsCross(dr_dp_B, x.p_B);
  }
};

}  // namespace

EdgeReprojectionXYZ::EdgeReprojectionXYZ(std::shared_ptr<VertexPointXYZ> p_W, std::shared_ptr<VertexPose> T_W_B,
                                         const Vec2& u, const Transform& T_B_C)
    : SizedEdge(std::move(p_W), std::move(T_W_B)), u_(u), T_B_C_(T_B_C) {}

CH5_FLATTEN void EdgeReprojectionXYZ::ComputeResidual() {
  r_ = Project(PointInCamera(RigidMatrix(GetVertex<1>()), T_B_C_, GetVertex<0>().GetEstimate()).p_C) - u_;
}

bool EdgeReprojectionXYZ::InDomain() const {
  return PointInCamera(RigidMatrix(GetVertex<1>()), T_B_C_, GetVertex<0>().GetEstimate()).p_C.z() > 0.0;
}

CH5_FLATTEN void EdgeReprojectionXYZ::Linearize() {
  const PointInCamera point(RigidMatrix(GetVertex<1>()), T_B_C_, GetVertex<0>().GetEstimate());
  r_ = Project(point.p_C) - u_;
  const PointInCameraJacobians d(point, T_B_C_);
  J<0>() = d.dr_dp_W;
  J<1>() = d.pose;
}

// ---- pose only -------------------------------------------------------------------------------------------------

EdgeReprojectionPoseOnly::EdgeReprojectionPoseOnly(std::shared_ptr<VertexPose> T_W_B, const Vec3& p_W, const Vec2& u,
                                                   const Transform& T_B_C)
    : SizedEdge(std::move(T_W_B)), p_W_(p_W), u_(u), T_B_C_(T_B_C) {}

void EdgeReprojectionPoseOnly::ComputeResidual() {
  r_ = Project(PointInCamera(RigidMatrix(GetVertex<0>()), T_B_C_, p_W_).p_C) - u_;
}

bool EdgeReprojectionPoseOnly::InDomain() const {
  return PointInCamera(RigidMatrix(GetVertex<0>()), T_B_C_, p_W_).p_C.z() > 0.0;
}

void EdgeReprojectionPoseOnly::ComputeJacobians() {
  J<0>() = PointInCameraJacobians(PointInCamera(RigidMatrix(GetVertex<0>()), T_B_C_, p_W_), T_B_C_).pose;
}

}  // namespace ch5
