#pragma once
/// The way of a landmark from its host's camera to another one, and the derivatives of its image there by all that lies on
/// the way:
///
///   p_Ci = f/λ,   p_Bi = T_B_Ci p_Ci,   p_W = T_W_Bi p_Bi,   p_Bj = T_W_Bj⁻¹ p_W,   p_Cj = T_B_Cj⁻¹ p_Bj,   π(p_Cj)
///
/// Each point is in the frame of its name, f = [u_i, v_i, 1]. With right perturbations R Exp(δθ):
///
///   ∂p_W/∂θ_i = −R_W_Bi [p_Bi],   ∂p_Bj/∂θ_j = [p_Bj],   ∂p_Ci/∂λ = −p_Ci/λ;   those of the cameras' places likewise

#include <cmath>

#include "ch5_backend/types/vertices.h"

namespace ch5 {

/// A rigid transform with its rotation as a matrix.
struct RigidMatrix {
  Mat33 R = Mat33::Identity();
  Vec3 p = Vec3::Zero();

  RigidMatrix() = default;
  /// A quaternion of another length is normalized; one of length 1 stays as it is, to the bit.
  /// @throws std::invalid_argument if it is zero or not finite
  explicit RigidMatrix(const Transform& T_B_C) : p(T_B_C.p) {
    const bool is_unit = std::abs(T_B_C.q.squaredNorm() - 1.0) < 1e-15;
    R = (is_unit ? T_B_C.q : RotationOf(T_B_C.q, "T_B_C")).toRotationMatrix();
  }
  explicit RigidMatrix(const VertexPose& T) : R(T.R()), p(T.p()) {}
  /// T⁻¹ x.
  Vec3 Inverse(const Vec3& x) const { return R.transpose() * (x - p); }
};

/// π: onto the plane z = 1.
inline Vec2 Project(const Vec3& p_C) { return p_C.head<2>() / p_C.z(); }

/// ∂π/∂p_C.
inline Mat23 ProjectionJacobian(const Vec3& p_C) {
  const double z_inverse = 1.0 / p_C.z();
  Mat23 dr_dp_C;
  dr_dp_C << z_inverse, 0.0, -p_C.x() * z_inverse * z_inverse,  //
      0.0, z_inverse, -p_C.y() * z_inverse * z_inverse;
  return dr_dp_C;
}

/// The points on the way at an inverse depth λ = `lambda`.
struct PointTransfer {
  Mat33 R_W_Bi, R_W_Bj;
  Vec3 p_Ci, p_Ci_in_B, p_Bi, p_Bj, p_Cj;  // p_Ci_in_B = R_B_Ci p_Ci

  PointTransfer(const Vec3& f_host, double lambda, const RigidMatrix& T_W_Bi, const RigidMatrix& T_W_Bj,
                const RigidMatrix& T_B_Ci, const RigidMatrix& T_B_Cj)
      : R_W_Bi(T_W_Bi.R),
        R_W_Bj(T_W_Bj.R),
        p_Ci(f_host / lambda),
        p_Ci_in_B(T_B_Ci.R * p_Ci),
        p_Bi(p_Ci_in_B + T_B_Ci.p),
        p_Bj(T_W_Bj.Inverse(R_W_Bi * p_Bi + T_W_Bi.p)),
        p_Cj(T_B_Cj.Inverse(p_Bj)) {}
};

/// The derivatives of the residual r = π(p_Cj) − u_j at these points.
struct TransferJacobians {
  Mat23 dr_dp_Cj, dr_dp_Bj, dr_dp_W, dr_dp_Bi;
  Vec2 inverse_depth;
  Mat26 pose_i, pose_j;

  TransferJacobians(const PointTransfer& x, double lambda, const RigidMatrix& T_B_Cj)
      : dr_dp_Cj(ProjectionJacobian(x.p_Cj)),
        dr_dp_Bj(dr_dp_Cj * T_B_Cj.R.transpose()),
        dr_dp_W(dr_dp_Bj * x.R_W_Bj.transpose()),
        dr_dp_Bi(dr_dp_W * x.R_W_Bi),
        inverse_depth(dr_dp_Bi * (x.p_Ci_in_B / -lambda)) {
    pose_i << dr_dp_W, -RowsCross(dr_dp_Bi, x.p_Bi);
    pose_j << -dr_dp_W, RowsCross(dr_dp_Bj, x.p_Bj);
  }
  /// ∂r/∂p_Ci.
  Mat23 ByPointInHost(const RigidMatrix& T_B_Ci) const { return dr_dp_Bi * T_B_Ci.R; }
  /// By the places of both cameras; where they are one camera, which acts on the way out and on the way in, by their sum.
  Mat26 CameraOfHost(const PointTransfer& x, const RigidMatrix& T_B_Ci) const {
    Mat26 J;
    J << dr_dp_Bi, -RowsCross(ByPointInHost(T_B_Ci), x.p_Ci);
    return J;
  }
  Mat26 CameraOfTarget(const PointTransfer& x) const {
    Mat26 J;
    J << -dr_dp_Bj, RowsCross(dr_dp_Cj, x.p_Cj);
    return J;
  }
};

}  // namespace ch5
