#include "ch5_backend/types/bal/edge_bal.h"

#include "ch5_backend/math/simd.h"

namespace ch5 {

bool EdgeBAL::InDomain() const {
  VertexCameraBAL::Rotation other;
  return GetVertex<0>().GetRotation(&other).R.row(2) * GetVertex<1>().GetEstimate() < -GetVertex<0>().GetEstimate()[5];
}

CH5_FLATTEN void EdgeBAL::ComputeResidual() {
  const Vec9& camera = GetVertex<0>().GetEstimate();
  VertexCameraBAL::Rotation other;
  const Vec3 P = GetVertex<0>().GetRotation(&other).R * GetVertex<1>().GetEstimate() + camera.segment<3>(3);
  const Vec2 p = -P.head<2>() / P.z();
  const double n = p.squaredNorm();
  r_ = camera[6] * (1.0 + n * (camera[7] + n * camera[8])) * p - pixel_;
}

CH5_FLATTEN void EdgeBAL::Linearize() {
  const Vec9& camera = GetVertex<0>().GetEstimate();
  const double f = camera[6], k1 = camera[7], k2 = camera[8];
  VertexCameraBAL::Rotation other;
  const VertexCameraBAL::Rotation& rotation = GetVertex<0>().GetRotation(&other);
  const Vec3 RX = rotation.R * GetVertex<1>().GetEstimate();
  const Vec3 P = RX + camera.segment<3>(3);
  const double z_inverse = -1.0 / P.z();
  const Vec2 p = P.head<2>() * z_inverse;
  const double n = p.squaredNorm();
  const double distortion = 1.0 + n * (k1 + n * k2);
  r_ = f * distortion * p - pixel_;

  // ∂u/∂p = f (d I + 2 (k1 + 2 k2 n) p pᵀ),  ∂p/∂P = −1/P.z [I | p],  ∂(Exp(ω)X)/∂ω = −[RX] J_l(ω)
  Mat23 du_dP;
  du_dP.leftCols<2>() = 2.0 * f * z_inverse * (k1 + 2.0 * k2 * n) * p * p.transpose();
  du_dP.diagonal().array() += f * z_inverse * distortion;
  du_dP.col(2) = du_dP.leftCols<2>() * p;
  J<0>() << RowsCross(du_dP, -RX) * rotation.J_l, du_dP, distortion * p, f * n * p, f * n * n * p;
  J<1>() = du_dP * rotation.R;
}

}  // namespace ch5
