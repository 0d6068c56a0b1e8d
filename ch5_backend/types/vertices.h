#pragma once
/// The unknowns of the chapter. Frames: W world, B body (IMU), C camera; T_W_B maps B-coordinates into W.

#include <stdexcept>

#include "ch5_backend/graph/vertex.h"
#include "ch5_backend/math/so3.h"

namespace ch5 {

/// A rigid transform (position p [m], Hamilton quaternion q) stored as [p, q_x, q_y, q_z, q_w].
/// Increment [δp, δθ]:  p ← p + δp,  q ← q ⊗ Exp(δθ);  ‖q‖ = 1 is kept by normalising after every step.
class VertexPose : public SizedVertex<7, 6> {
 public:
  VertexPose() : VertexPose(Qd::Identity(), Vec3::Zero()) {}
  /// @param q  rotation, normalised here;  @param p  position [m]
  /// @throws std::invalid_argument if q has no length, so no direction
  VertexPose(const Qd& q, const Vec3& p) : SizedVertex(Pack(q, p), Role::kPose) {}

  Vec3 p() const { return x_.head<3>(); }
  Qd q() const { return Qd(x_[6], x_[3], x_[4], x_[5]); }
  Mat33 R() const { return q().toRotationMatrix(); }
  /// As the constructor.
  void SetPose(const Qd& q, const Vec3& p) { x_ = Pack(q, p); }

  void Plus(const double* delta) override {
    const Qd rotated = q() * ExpSO3(Eigen::Map<const Vec3>(delta + 3));
    x_ = Pack(rotated, p() + Eigen::Map<const Vec3>(delta));
  }
  /// [p − p₀; 2 vec(q₀⁻¹ q)] with the sign of q₀⁻¹q that makes its scalar positive: the shorter way round.
  VecX Minus(const VecX& x0) const override {
    const Qd dq = Difference(x0);
    Vec6 delta;
    delta << p() - x0.head<3>(), 2.0 * dq.vec();
    return delta;
  }
  /// 2 vec(dq ⊗ [1, ½δ]) = 2 vec(dq) + (dq_w I + [dq_v]) δ.
  MatXX MinusJacobian(const VecX& x0) const override {
    const Qd dq = Difference(x0);
    Mat66 J = Mat66::Identity();
    J.bottomRightCorner<3, 3>() = dq.w() * Mat33::Identity() + Hat(dq.vec());
    return J;
  }
  std::string TypeInfo() const override { return "VertexPose"; }

 protected:
  static Vec7 Pack(const Qd& q, const Vec3& p) {
    if (q.squaredNorm() == 0.0) throw std::invalid_argument("VertexPose: the quaternion is zero");
    Vec7 x;
    x << p, q.normalized().coeffs();
    return x;
  }

 private:
  Qd Difference(const VecX& x0) const {
    Qd dq = Qd(x0[6], x0[3], x0[4], x0[5]).conjugate() * q();
    if (dq.w() < 0.0) dq.coeffs() = -dq.coeffs();
    return dq;
  }
};

/// The pose that holds a gauge, the first one as a rule. Its rotation is always updated from its initial value R⁰:
///
///   R = Exp(Δφ) R⁰,   Δφ ← Δφ + J_l⁻¹(Δφ) R δθ
///
/// To first order this is R Exp(δθ), so the Jacobians are those of VertexPose. But steps with e_zᵀ J_l⁻¹(Δφ) R δθ = 0
/// keep the yaw e_zᵀΔφ exactly; a product of many Exp(δθ) does so to first order only, and the yaw drifts.
/// Source: Zhang, Gallego, Scaramuzza, RA-L 2018, §IV.
class VertexReferencePose : public VertexPose {
 public:
  /// As VertexPose; `q` and `p` are the initial values.
  VertexReferencePose(const Qd& q, const Vec3& p) : VertexPose(q, p), q0_(q.normalized()), p0_(p) {}

  const Vec3& InitialPosition() const { return p0_; }
  /// Δφ = Log(R R⁰ᵀ) [rad], along W's axes; ‖Δφ‖ < π.
  Vec3 DeltaPhi() const { return LogSO3(q() * q0_.conjugate()); }
  /// ∂Δφ/∂δθ = J_l⁻¹(Δφ) R.
  Mat33 DeltaPhiJacobian() const { return RightJacobianInverseSO3(-DeltaPhi()) * R(); }

  void Plus(const double* delta) override {
    const Vec3 phi = DeltaPhi() + DeltaPhiJacobian() * Eigen::Map<const Vec3>(delta + 3);
    x_ = Pack(ExpSO3(phi) * q0_, p() + Eigen::Map<const Vec3>(delta));
  }
  std::string TypeInfo() const override { return "VertexReferencePose"; }

 private:
  Qd q0_;
  Vec3 p0_;
};

/// Velocity of B in W [m/s], accelerometer bias [m/s²] and gyroscope bias [rad/s], stored [v, b_a, b_g].
class VertexSpeedBias : public SizedVertex<9, 9> {
 public:
  explicit VertexSpeedBias(const Vec9& v_ba_bg = Vec9::Zero()) : SizedVertex(v_ba_bg, Role::kPose) {}
  Vec3 v() const { return x_.head<3>(); }
  Vec3 b_a() const { return x_.segment<3>(3); }
  Vec3 b_g() const { return x_.tail<3>(); }
  std::string TypeInfo() const override { return "VertexSpeedBias"; }
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
/// One number.
using VertexScalar = VertexVector<1>;

/// A camera of a BAL problem: angle-axis ω [rad] and translation t of X_C = Exp(ω) X_W + t, focal length f [px],
/// radial distortion k1, k2. The nine numbers add, as in Ceres' example.
class VertexCameraBAL : public SizedVertex<9, 9> {
 public:
  /// What every observation needs of ω.
  struct Rotation {
    Vec3 omega;
    Mat33 R;    ///< Exp(ω)
    Mat33 J_l;  ///< left Jacobian of ω
  };

  explicit VertexCameraBAL(const Vec9& camera)
      : SizedVertex(camera, Role::kPose), rotation_(Rotate(camera.head<3>())), before_(rotation_) {}

  void Plus(const double* delta) override {
    if (rotation_.omega == x_.head<3>()) before_ = rotation_;
    x_ += Eigen::Map<const Vec9>(delta);
    rotation_ = Rotate(x_.head<3>());
  }
  /// Worked out once a step for all observations, and kept for the step's undoing; `other` holds the answer where ω has
  /// been changed by other means.
  const Rotation& GetRotation(Rotation* other) const {
    if (rotation_.omega == x_.head<3>()) return rotation_;
    if (before_.omega == x_.head<3>()) return before_;
    *other = Rotate(x_.head<3>());
    return *other;
  }
  std::string TypeInfo() const override { return "VertexCameraBAL"; }

 private:
  static Rotation Rotate(const Vec3& omega) {
    return {omega, ExpSO3(omega).toRotationMatrix(), LeftJacobianSO3(omega)};
  }
  Rotation rotation_, before_;  // of the present ω, of that before the last step
};

}  // namespace ch5
