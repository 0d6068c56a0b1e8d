#include "ch5_backend/types/visual/edge_stereo.h"

namespace ch5 {
namespace {

Vec3 FromCamera(const VertexPose& T_B_C, const Vec3& p_C) { return T_B_C.q() * p_C + T_B_C.p(); }
Vec3 ToCamera(const VertexPose& T_B_C, const Vec3& p_B) { return T_B_C.q().conjugate() * (p_B - T_B_C.p()); }

Mat23 ProjectionJacobian(const Vec3& p_C) {
  const double z_inverse = 1.0 / p_C.z();
  Mat23 dr_dp_C;
  dr_dp_C << z_inverse, 0.0, -p_C.x() * z_inverse * z_inverse,  //
      0.0, z_inverse, -p_C.y() * z_inverse * z_inverse;
  return dr_dp_C;
}

// The Jacobians that both edges have, in this order: inverse depth, T_B_C0, T_B_C1, time offset.
// @param dr_dp_Bi, dr_dp_Bj  the same if the host's frame is the target's
void DifferentiateCameras(const VertexPose& T_B_C0, double lambda, const Vec3& p_Ci, const Vec3& p_Cj,
                          const Mat23& dr_dp_Cj, const Mat23& dr_dp_Bi, const Mat23& dr_dp_Bj,
                          const Vec2& host_velocity, const Vec2& target_velocity, const std::array<double*, 4>& J) {
  const Mat23 dr_dp_Ci = dr_dp_Bi * T_B_C0.R();
  if (J[0]) Eigen::Map<Vec2>{J[0]} = dr_dp_Ci * p_Ci / -lambda;
  if (J[1]) Eigen::Map<Mat26>{J[1]} << dr_dp_Bi, -RowsCross(dr_dp_Ci, p_Ci);
  if (J[2]) Eigen::Map<Mat26>{J[2]} << -dr_dp_Bj, RowsCross(dr_dp_Cj, p_Cj);
  // dx̂/dtd = −ẋ:  through the host's ray, and directly in the target.
  if (J[3]) Eigen::Map<Vec2>{J[3]} = target_velocity - dr_dp_Ci.leftCols<2>() * host_velocity / lambda;
}

}  // namespace

// ---- two frames ------------------------------------------------------------------------------------------------

EdgeStereo::EdgeStereo(std::shared_ptr<VertexInverseDepth> inverse_depth, std::shared_ptr<VertexPose> T_W_Bi,
                       std::shared_ptr<VertexPose> T_W_Bj, std::shared_ptr<VertexPose> T_B_C0,
                       std::shared_ptr<VertexPose> T_B_C1, std::shared_ptr<VertexScalar> time_offset,
                       const MovingPoint& host, const MovingPoint& target)
    : SizedEdge(std::move(inverse_depth), std::move(T_W_Bi), std::move(T_W_Bj), std::move(T_B_C0), std::move(T_B_C1),
                std::move(time_offset)),
      host_(host),
      target_(target) {}

Vec3 EdgeStereo::PointInTarget() const {
  const VertexPose &T_W_Bi = GetVertex<1>(), &T_W_Bj = GetVertex<2>();
  const double td = GetVertex<5>().GetEstimate()[0];
  const Vec3 p_Bi = FromCamera(GetVertex<3>(), host_.At(td).homogeneous() / GetVertex<0>().InverseDepth());
  const Vec3 p_Bj = T_W_Bj.q().conjugate() * (T_W_Bi.q() * p_Bi + T_W_Bi.p() - T_W_Bj.p());
  return ToCamera(GetVertex<4>(), p_Bj);
}

void EdgeStereo::ComputeResidual() { r_ = PointInTarget().hnormalized() - target_.At(GetVertex<5>().GetEstimate()[0]); }

bool EdgeStereo::LinearizeInto(double* r, double* const* J) const {
  const VertexPose &T_W_Bi = GetVertex<1>(), &T_W_Bj = GetVertex<2>(), &T_B_C0 = GetVertex<3>(),
                   &T_B_C1 = GetVertex<4>();
  const double lambda = GetVertex<0>().InverseDepth(), td = GetVertex<5>().GetEstimate()[0];
  const Mat33 R_W_Bi = T_W_Bi.R(), R_B_W = T_W_Bj.R().transpose();
  const Vec3 p_Ci = host_.At(td).homogeneous() / lambda;
  const Vec3 p_Bi = FromCamera(T_B_C0, p_Ci);
  const Vec3 p_Bj = R_B_W * (R_W_Bi * p_Bi + T_W_Bi.p() - T_W_Bj.p());
  const Vec3 p_Cj = ToCamera(T_B_C1, p_Bj);
  Eigen::Map<Vec2>{r} = p_Cj.hnormalized() - target_.At(td);

  const Mat23 dr_dp_Cj = ProjectionJacobian(p_Cj);
  const Mat23 dr_dp_Bj = dr_dp_Cj * T_B_C1.R().transpose();
  const Mat23 dr_dp_W = dr_dp_Bj * R_B_W;
  const Mat23 dr_dp_Bi = dr_dp_W * R_W_Bi;
  if (J[1]) Eigen::Map<Mat26>{J[1]} << dr_dp_W, -RowsCross(dr_dp_Bi, p_Bi);
  if (J[2]) Eigen::Map<Mat26>{J[2]} << -dr_dp_W, RowsCross(dr_dp_Bj, p_Bj);
  DifferentiateCameras(T_B_C0, lambda, p_Ci, p_Cj, dr_dp_Cj, dr_dp_Bi, dr_dp_Bj, host_.velocity, target_.velocity,
                       {J[0], J[3], J[4], J[5]});
  return true;
}

// ---- the host's frame ------------------------------------------------------------------------------------------

EdgeStereoHost::EdgeStereoHost(std::shared_ptr<VertexInverseDepth> inverse_depth, std::shared_ptr<VertexPose> T_B_C0,
                               std::shared_ptr<VertexPose> T_B_C1, std::shared_ptr<VertexScalar> time_offset,
                               const MovingPoint& host, const MovingPoint& target)
    : SizedEdge(std::move(inverse_depth), std::move(T_B_C0), std::move(T_B_C1), std::move(time_offset)),
      host_(host),
      target_(target) {}

Vec3 EdgeStereoHost::PointInTarget() const {
  const double td = GetVertex<3>().GetEstimate()[0];
  const Vec3 p_B = FromCamera(GetVertex<1>(), host_.At(td).homogeneous() / GetVertex<0>().InverseDepth());
  return ToCamera(GetVertex<2>(), p_B);
}

void EdgeStereoHost::ComputeResidual() {
  r_ = PointInTarget().hnormalized() - target_.At(GetVertex<3>().GetEstimate()[0]);
}

bool EdgeStereoHost::LinearizeInto(double* r, double* const* J) const {
  const VertexPose &T_B_C0 = GetVertex<1>(), &T_B_C1 = GetVertex<2>();
  const double lambda = GetVertex<0>().InverseDepth(), td = GetVertex<3>().GetEstimate()[0];
  const Vec3 p_C0 = host_.At(td).homogeneous() / lambda;
  const Vec3 p_C1 = ToCamera(T_B_C1, FromCamera(T_B_C0, p_C0));
  Eigen::Map<Vec2>{r} = p_C1.hnormalized() - target_.At(td);
  const Mat23 dr_dp_C1 = ProjectionJacobian(p_C1);
  const Mat23 dr_dp_B = dr_dp_C1 * T_B_C1.R().transpose();
  DifferentiateCameras(T_B_C0, lambda, p_C0, p_C1, dr_dp_C1, dr_dp_B, dr_dp_B, host_.velocity, target_.velocity,
                       {J[0], J[1], J[2], J[3]});
  return true;
}

}  // namespace ch5
