#include "ch5_backend/types/visual/edge_reprojection_calibration.h"

namespace ch5 {

EdgeReprojectionCalibration::EdgeReprojectionCalibration(std::shared_ptr<VertexInverseDepth> inverse_depth,
                                                         std::shared_ptr<VertexPose> T_W_Bi,
                                                         std::shared_ptr<VertexPose> T_W_Bj,
                                                         std::shared_ptr<VertexPose> T_B_C,
                                                         std::shared_ptr<VertexScalar> time_offset,
                                                         const MovingPoint& host, const MovingPoint& target)
    : SizedEdge(std::move(inverse_depth), std::move(T_W_Bi), std::move(T_W_Bj), std::move(T_B_C),
                std::move(time_offset)),
      host_(host),
      target_(target) {}

Vec3 EdgeReprojectionCalibration::PointInTarget() const {
  const VertexPose &T_W_Bi = GetVertex<1>(), &T_W_Bj = GetVertex<2>(), &T_B_C = GetVertex<3>();
  const double td = GetVertex<4>().GetEstimate()[0];
  const Vec3 p_Ci = host_.At(td).homogeneous() / GetVertex<0>().InverseDepth();
  const Vec3 p_W = T_W_Bi.q() * (T_B_C.q() * p_Ci + T_B_C.p()) + T_W_Bi.p();
  const Vec3 p_Bj = T_W_Bj.q().conjugate() * (p_W - T_W_Bj.p());
  return T_B_C.q().conjugate() * (p_Bj - T_B_C.p());
}

void EdgeReprojectionCalibration::ComputeResidual() {
  r_ = PointInTarget().hnormalized() - target_.At(GetVertex<4>().GetEstimate()[0]);
}

bool EdgeReprojectionCalibration::InDomain() const {
  return GetVertex<0>().InverseDepth() > 0.0 && PointInTarget().z() > 0.0;
}

void EdgeReprojectionCalibration::ComputeJacobians() {
  const VertexPose &T_W_Bi = GetVertex<1>(), &T_W_Bj = GetVertex<2>(), &T_B_C = GetVertex<3>();
  const double lambda = GetVertex<0>().InverseDepth(), td = GetVertex<4>().GetEstimate()[0];
  const Mat33 R_W_Bi = T_W_Bi.R(), R_B_W = T_W_Bj.R().transpose(), R_B_C = T_B_C.R();
  const Vec3 p_Ci = host_.At(td).homogeneous() / lambda;
  const Vec3 p_Bi = R_B_C * p_Ci + T_B_C.p();
  const Vec3 p_Bj = R_B_W * (R_W_Bi * p_Bi + T_W_Bi.p() - T_W_Bj.p());
  const Vec3 p_Cj = R_B_C.transpose() * (p_Bj - T_B_C.p());

  const double z_inverse = 1.0 / p_Cj.z();
  Mat23 dr_dp_Cj;
  dr_dp_Cj << z_inverse, 0.0, -p_Cj.x() * z_inverse * z_inverse,  //
      0.0, z_inverse, -p_Cj.y() * z_inverse * z_inverse;
  const Mat23 dr_dp_Bj = dr_dp_Cj * R_B_C.transpose();
  const Mat23 dr_dp_W = dr_dp_Bj * R_B_W;
  const Mat23 dr_dp_Bi = dr_dp_W * R_W_Bi;
  const Mat23 dr_dp_Ci = dr_dp_Bi * R_B_C;

  J<0>() = dr_dp_Ci * p_Ci / -lambda;
  J<1>() << dr_dp_W, -RowsCross(dr_dp_Bi, p_Bi);
  J<2>() << -dr_dp_W, RowsCross(dr_dp_Bj, p_Bj);
  // The extrinsic acts twice, on the way out of camera i and on the way into camera j.
  J<3>() << dr_dp_Bi - dr_dp_Bj, -RowsCross(dr_dp_Ci, p_Ci) + RowsCross(dr_dp_Cj, p_Cj);
  // dx̂/dtd = −ẋ:  through the host's ray, and directly in the target.
  J<4>() = target_.velocity - dr_dp_Ci.leftCols<2>() * host_.velocity / lambda;
}

}  // namespace ch5
