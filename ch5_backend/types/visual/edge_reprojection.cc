#include "ch5_backend/types/visual/edge_reprojection.h"

#include "ch5_backend/math/simd.h"

namespace ch5 {
namespace {

Vec2 Project(const Vec3& p_C) { return p_C.head<2>() / p_C.z(); }

// ∂(x/z, y/z)/∂p_C
Mat23 ProjectionJacobian(const Vec3& p_C) {
  const double z_inverse = 1.0 / p_C.z();
  Mat23 dr_dp_C;
  dr_dp_C << z_inverse, 0.0, -p_C.x() * z_inverse * z_inverse,  //
      0.0, z_inverse, -p_C.y() * z_inverse * z_inverse;
  return dr_dp_C;
}

// p_C = R_B_Cᵀ (R_W_Bᵀ (p_W − p_W_B) − p_B_C)
Vec3 WorldToCamera(const VertexPose& T_W_B, const Mat33& R_B_C, const Vec3& p_B_C, const Vec3& p_W) {
  return R_B_C.transpose() * (T_W_B.R().transpose() * (p_W - T_W_B.p()) - p_B_C);
}

// The chain of an inverse-depth landmark from host to target, each point in the frame of its name.
struct Chain {
  Mat33 R_W_Bi, R_W_Bj;
  Vec3 p_Ci, p_Ci_in_B, p_Bi, p_Bj, p_Cj;  // p_Ci_in_B = R_B_C p_Ci
};

Chain Transfer(double inverse_depth, const Vec3& f_host, const VertexPose& T_W_Bi, const VertexPose& T_W_Bj,
               const Mat33& R_B_C, const Vec3& p_B_C) {
  Chain c;
  c.R_W_Bi = T_W_Bi.R();
  c.R_W_Bj = T_W_Bj.R();
  c.p_Ci = f_host / inverse_depth;
  c.p_Ci_in_B = R_B_C * c.p_Ci;
  c.p_Bi = c.p_Ci_in_B + p_B_C;
  const Vec3 p_W = c.R_W_Bi * c.p_Bi + T_W_Bi.p();
  c.p_Bj = c.R_W_Bj.transpose() * (p_W - T_W_Bj.p());
  c.p_Cj = R_B_C.transpose() * (c.p_Bj - p_B_C);
  return c;
}

// The three Jacobians that both inverse-depth edges share, right perturbations R Exp(δθ):
//   ∂p_W/∂θ_i = −R_W_Bi [p_Bi],  ∂p_Bj/∂θ_j = [p_Bj],  ∂p_Ci/∂λ = −p_Ci/λ.
struct ChainJacobians {
  Eigen::Matrix<double, 2, 1> inverse_depth;
  Mat26 pose_i, pose_j;
  Mat23 dr_dp_Bj;
};

ChainJacobians Differentiate(const Chain& c, double inverse_depth, const Mat33& R_B_C) {
  ChainJacobians d;
  d.dr_dp_Bj.noalias() = ProjectionJacobian(c.p_Cj) * R_B_C.transpose();
  const Mat23 dr_dp_W = d.dr_dp_Bj * c.R_W_Bj.transpose();
  const Mat23 dr_dp_Bi = dr_dp_W * c.R_W_Bi;
  d.inverse_depth.noalias() = dr_dp_Bi * (c.p_Ci_in_B / -inverse_depth);
  d.pose_i << dr_dp_W, -RowsCross(dr_dp_Bi, c.p_Bi);
  d.pose_j << -dr_dp_W, RowsCross(d.dr_dp_Bj, c.p_Bj);
  return d;
}

}  // namespace

// ---- inverse depth, extrinsic constant -------------------------------------------------------------------------

EdgeReprojection::EdgeReprojection(std::shared_ptr<VertexInverseDepth> inverse_depth,
                                   std::shared_ptr<VertexPose> T_W_Bi, std::shared_ptr<VertexPose> T_W_Bj,
                                   const Vec2& u_host, const Vec2& u_target, const Transform& T_B_C)
    : SizedEdge(std::move(inverse_depth), std::move(T_W_Bi), std::move(T_W_Bj)),
      f_host_(u_host.homogeneous()),
      u_target_(u_target),
      R_B_C_(T_B_C.q.toRotationMatrix()),
      p_B_C_(T_B_C.p) {}

// r = π(T_C_B T_Bj_W T_W_Bi T_B_C f/λ) − u.  Qin (2018), on the plane z = 1
CH5_FLATTEN void EdgeReprojection::ComputeResidual() {
  const double inverse_depth = GetVertex<0>().InverseDepth();
  r_ = Project(Transfer(inverse_depth, f_host_, GetVertex<1>(), GetVertex<2>(), R_B_C_, p_B_C_).p_Cj) - u_target_;
}

bool EdgeReprojection::InDomain() const {
  const double inverse_depth = GetVertex<0>().InverseDepth();
  return inverse_depth > 0.0 &&
         Transfer(inverse_depth, f_host_, GetVertex<1>(), GetVertex<2>(), R_B_C_, p_B_C_).p_Cj.z() > 0.0;
}

void EdgeReprojection::Linearize() { LinearizeInto(OwnResidual(), OwnJacobians()); }

CH5_FLATTEN bool EdgeReprojection::LinearizeInto(double* r, double* const* J) const {
  const double inverse_depth = GetVertex<0>().InverseDepth();
  const Chain chain = Transfer(inverse_depth, f_host_, GetVertex<1>(), GetVertex<2>(), R_B_C_, p_B_C_);
  Eigen::Map<Vec2>{r} = Project(chain.p_Cj) - u_target_;
  const ChainJacobians d = Differentiate(chain, inverse_depth, R_B_C_);
  if (J[0]) Eigen::Map<Vec2>{J[0]} = d.inverse_depth;
  if (J[1]) Eigen::Map<Mat26>{J[1]} = d.pose_i;
  if (J[2]) Eigen::Map<Mat26>{J[2]} = d.pose_j;
  return true;
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

void EdgeReprojectionExtrinsic::ComputeResidual() {
  const VertexPose& T_B_C = GetVertex<3>();
  const double inverse_depth = GetVertex<0>().InverseDepth();
  r_ = Project(Transfer(inverse_depth, f_host_, GetVertex<1>(), GetVertex<2>(), T_B_C.R(), T_B_C.p()).p_Cj) - u_target_;
}

bool EdgeReprojectionExtrinsic::InDomain() const {
  const VertexPose& T_B_C = GetVertex<3>();
  const double inverse_depth = GetVertex<0>().InverseDepth();
  return inverse_depth > 0.0 &&
         Transfer(inverse_depth, f_host_, GetVertex<1>(), GetVertex<2>(), T_B_C.R(), T_B_C.p()).p_Cj.z() > 0.0;
}

void EdgeReprojectionExtrinsic::ComputeJacobians() {
  const Mat33 R_B_C = GetVertex<3>().R();
  const double inverse_depth = GetVertex<0>().InverseDepth();
  const Chain chain = Transfer(inverse_depth, f_host_, GetVertex<1>(), GetVertex<2>(), R_B_C, GetVertex<3>().p());
  const ChainJacobians d = Differentiate(chain, inverse_depth, R_B_C);
  J<0>() = d.inverse_depth;
  J<1>() = d.pose_i;
  J<2>() = d.pose_j;
  // The extrinsic acts twice: p_Bi = R_B_C p_Ci + p_B_C on the way out, p_Cj = R_B_Cᵀ(p_Bj − p_B_C) on the way in.
  //   ∂p_Bj/∂p_B_C = R_Bj_Bi − I;   ∂p_Cj/∂θ_B_C = −R_B_Cᵀ R_Bj_Bi R_B_C [p_Ci] + [p_Cj]
  const Mat33 R_Bj_Bi = chain.R_W_Bj.transpose() * chain.R_W_Bi;
  const Mat23 dr_dp_Cj = ProjectionJacobian(chain.p_Cj);
  J<3>() << d.dr_dp_Bj * (R_Bj_Bi - Mat33::Identity()),
      -RowsCross(d.dr_dp_Bj * R_Bj_Bi * R_B_C, chain.p_Ci) + RowsCross(dr_dp_Cj, chain.p_Cj);
}

// ---- 3-D point -------------------------------------------------------------------------------------------------

EdgeReprojectionXYZ::EdgeReprojectionXYZ(std::shared_ptr<VertexPointXYZ> p_W, std::shared_ptr<VertexPose> T_W_B,
                                         const Vec2& u, const Transform& T_B_C)
    : SizedEdge(std::move(p_W), std::move(T_W_B)), u_(u), R_B_C_(T_B_C.q.toRotationMatrix()), p_B_C_(T_B_C.p) {}

CH5_FLATTEN void EdgeReprojectionXYZ::ComputeResidual() {
  r_ = Project(WorldToCamera(GetVertex<1>(), R_B_C_, p_B_C_, GetVertex<0>().GetEstimate())) - u_;
}

bool EdgeReprojectionXYZ::InDomain() const {
  return WorldToCamera(GetVertex<1>(), R_B_C_, p_B_C_, GetVertex<0>().GetEstimate()).z() > 0.0;
}

void EdgeReprojectionXYZ::Linearize() { LinearizeInto(OwnResidual(), OwnJacobians()); }

CH5_FLATTEN bool EdgeReprojectionXYZ::LinearizeInto(double* r, double* const* J) const {
  const VertexPose& T_W_B = GetVertex<1>();
  const Mat33 R_W_B = T_W_B.R();
  const Vec3 p_B = R_W_B.transpose() * (GetVertex<0>().GetEstimate() - T_W_B.p());
  const Vec3 p_C = R_B_C_.transpose() * (p_B - p_B_C_);
  Eigen::Map<Vec2>{r} = Project(p_C) - u_;
  const Mat23 dr_dp_B = ProjectionJacobian(p_C) * R_B_C_.transpose();
  const Mat23 dr_dp_W = dr_dp_B * R_W_B.transpose();
  if (J[0]) Eigen::Map<Mat23>{J[0]} = dr_dp_W;
  if (J[1]) Eigen::Map<Mat26>{J[1]} << -dr_dp_W, RowsCross(dr_dp_B, p_B);
  return true;
}

// ---- pose only -------------------------------------------------------------------------------------------------

EdgeReprojectionPoseOnly::EdgeReprojectionPoseOnly(std::shared_ptr<VertexPose> T_W_B, const Vec3& p_W, const Vec2& u,
                                                   const Transform& T_B_C)
    : SizedEdge(std::move(T_W_B)), p_W_(p_W), u_(u), R_B_C_(T_B_C.q.toRotationMatrix()), p_B_C_(T_B_C.p) {}

void EdgeReprojectionPoseOnly::ComputeResidual() {
  r_ = Project(WorldToCamera(GetVertex<0>(), R_B_C_, p_B_C_, p_W_)) - u_;
}

bool EdgeReprojectionPoseOnly::InDomain() const {
  return WorldToCamera(GetVertex<0>(), R_B_C_, p_B_C_, p_W_).z() > 0.0;
}

void EdgeReprojectionPoseOnly::ComputeJacobians() {
  const VertexPose& T_W_B = GetVertex<0>();
  const Mat33 R_W_B = T_W_B.R();
  const Vec3 p_B = R_W_B.transpose() * (p_W_ - T_W_B.p());
  const Mat23 dr_dp_B = ProjectionJacobian(R_B_C_.transpose() * (p_B - p_B_C_)) * R_B_C_.transpose();
  J<0>() << -dr_dp_B * R_W_B.transpose(), RowsCross(dr_dp_B, p_B);
}

}  // namespace ch5
