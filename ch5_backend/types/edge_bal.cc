#include "ch5_backend/types/edge_bal.h"

namespace ch5 {

void EdgeBAL::ComputeResidual() {
  const Vec9& camera = GetVertex<0>().GetEstimate();
  VertexCameraBAL::Rotation other;
  const Vec3 P = GetVertex<0>().GetRotation(&other).R * GetVertex<1>().GetEstimate() + camera.segment<3>(3);
  const Vec2 p = -P.head<2>() / P.z();
  const double n = p.squaredNorm();
  r_ = camera[6] * (1.0 + n * (camera[7] + n * camera[8])) * p - pixel_;
}

void EdgeBAL::Linearize() {
  const Vec9& camera = GetVertex<0>().GetEstimate();
  const double f = camera[6], k1 = camera[7], k2 = camera[8];
  VertexCameraBAL::Rotation other;
  const VertexCameraBAL::Rotation& rotation = GetVertex<0>().GetRotation(&other);
  const Vec3 RX = rotation.R * GetVertex<1>().GetEstimate();
  const Vec3 P = RX + camera.segment<3>(3);
  const Vec2 p = -P.head<2>() / P.z();
  const double n = p.squaredNorm();
  const double distortion = 1.0 + n * (k1 + n * k2);
  r_ = f * distortion * p - pixel_;

  // ∂u/∂p = f (d I + 2 (k1 + 2 k2 n) p pᵀ),  ∂p/∂P = −1/P.z [I | p],  ∂(Exp(ω)X)/∂ω = −[RX] J_l(ω)
  const Mat22 du_dp = f * (distortion * Mat22::Identity() + 2.0 * (k1 + 2.0 * k2 * n) * p * p.transpose());
  Mat23 dp_dP;
  dp_dP << Mat22::Identity(), p;
  const Mat23 du_dP = du_dp * dp_dP / -P.z();

  J<0>().leftCols<3>() = RowsCross(du_dP, -RX) * rotation.J_l;
  J<0>().middleCols<3>(3) = du_dP;
  J<0>().col(6) = distortion * p;
  J<0>().col(7) = f * n * p;
  J<0>().col(8) = f * n * n * p;
  J<1>() = du_dP * rotation.R;
}

}  // namespace ch5
