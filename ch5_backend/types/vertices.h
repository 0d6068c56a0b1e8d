#pragma once
/// The unknowns of the chapter. Frames: W world, B body (IMU), C camera; T_W_B maps B-coordinates into W.

#include "ch5_backend/graph/vertex.h"
#include "ch5_backend/math/so3.h"

namespace ch5 {

/// A rigid transform (position p [m], Hamilton quaternion q) stored as [p, q_x, q_y, q_z, q_w].
/// Increment [δp, δθ]:  p ← p + δp,  q ← q ⊗ Exp(δθ);  ‖q‖ = 1 is kept by normalising after every step.
class VertexPose : public SizedVertex<7, 6> {
 public:
  VertexPose() : VertexPose(Qd::Identity(), Vec3::Zero()) {}
  /// @param q  rotation, normalised here;  @param p  position [m]
  VertexPose(const Qd& q, const Vec3& p) : SizedVertex(Pack(q, p), Role::kPose) {}

  Vec3 p() const { return x_.head<3>(); }
  Qd q() const { return Qd(x_[6], x_[3], x_[4], x_[5]); }
  Mat33 R() const { return q().toRotationMatrix(); }
  void SetPose(const Qd& q, const Vec3& p) { x_ = Pack(q, p); }

  void Plus(const double* delta) override {
    const Qd rotated = q() * ExpSO3(Eigen::Map<const Vec3>(delta + 3));
    x_ = Pack(rotated, p() + Eigen::Map<const Vec3>(delta));
  }
  std::string TypeInfo() const override { return "VertexPose"; }

 private:
  static Vec7 Pack(const Qd& q, const Vec3& p) {
    Vec7 x;
    x << p, q.normalized().coeffs();
    return x;
  }
};

/// 1/depth [1/m] of a landmark in the camera frame of its host.
class VertexInverseDepth : public SizedVertex<1, 1> {
 public:
  explicit VertexInverseDepth(double inverse_depth) : SizedVertex(Estimate(inverse_depth), Role::kLandmark) {}
  double InverseDepth() const { return x_[0]; }
  std::string TypeInfo() const override { return "VertexInverseDepth"; }
};

/// A landmark's coordinates [m] in the world frame.
class VertexPointXYZ : public SizedVertex<3, 3> {
 public:
  explicit VertexPointXYZ(const Vec3& p_W) : SizedVertex(p_W, Role::kLandmark) {}
  std::string TypeInfo() const override { return "VertexPointXYZ"; }
};

/// `N` numbers that add, such as the coefficients of a curve. Counts as a pose: it is not eliminated.
template <int N>
class VertexVector : public SizedVertex<N, N> {
 public:
  explicit VertexVector(const Eigen::Matrix<double, N, 1>& x) : SizedVertex<N, N>(x, Role::kPose) {}
  std::string TypeInfo() const override { return "VertexVector" + std::to_string(N); }
};
using VertexScalar = VertexVector<1>;

/// A camera of a BAL problem: angle-axis ω [rad] and translation t of X_C = Exp(ω) X_W + t, focal length f [px],
/// radial distortion k1, k2. The nine numbers add, as in Ceres' example.
class VertexCameraBAL : public SizedVertex<9, 9> {
 public:
  explicit VertexCameraBAL(const Vec9& camera) : SizedVertex(camera, Role::kPose) {}
  std::string TypeInfo() const override { return "VertexCameraBAL"; }
};

}  // namespace ch5
