#pragma once
/// The unknowns of the chapter. Frames: W world, B body (IMU), C camera; T_W_B maps B-coordinates into W.

#include <string>

#include "ch5_backend/graph/vertex.h"
#include "ch5_backend/math/so3.h"

namespace ch5 {

/// q of length 1.  @param of  what asks, for the message
/// @throws std::invalid_argument if q is zero or not finite
Qd RotationOf(const Qd& q, const char* of);

/// A rigid transform (position p [m], Hamilton quaternion q) stored as [p, q_x, q_y, q_z, q_w].
/// Increment [δp, δθ]:  p ← p + δp,  q ← q ⊗ Exp(δθ);  ‖q‖ = 1 is kept by normalizing after every step.
class VertexPose : public SizedVertex<7, 6> {
 public:
  VertexPose();
  /// @param q  rotation, normalized here;  @param p  position [m]
  /// @throws std::invalid_argument if q has no length, so no direction
  VertexPose(const Qd& q, const Vec3& p);

  Vec3 p() const { return x_.head<3>(); }
  Qd q() const { return Qd(x_[6], x_[3], x_[4], x_[5]); }
  Mat33 R() const { return q().toRotationMatrix(); }
  /// Like the constructor.
  void SetPose(const Qd& q, const Vec3& p);
  /// The same of [p, q_x, q_y, q_z, q_w]; what another pose gave stays as it is, to the bit.
  void SetEstimate(const Estimate& x);

  void Plus(const double* delta) override;
  /// [p − p₀; 2 vec(q₀⁻¹ q)] with the sign of q₀⁻¹q that makes its scalar positive: the shorter way round.
  VecX Minus(const VecX& x0) const final;
  /// 2 vec(dq ⊗ [1, ½δ]) = 2 vec(dq) + (dq_w I + [dq_v]) δ.
  MatXX MinusJacobian(const VecX& x0) const final;
  void MinusInto(const VecX& x0, double* delta, double* derivative) const final;
  std::string TypeInfo() const override { return "VertexPose"; }

 private:
  Qd Difference(const VecX& x0) const;
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
  VertexReferencePose(const Qd& q, const Vec3& p);

  const Vec3& InitialPosition() const { return p0_; }
  /// Δφ = Log(R R⁰ᵀ) [rad], along W's axes; ‖Δφ‖ < π.
  Vec3 DeltaPhi() const;
  /// ∂Δφ/∂δθ = J_l⁻¹(Δφ) R.
  Mat33 DeltaPhiJacobian() const;

  void Plus(const double* delta) override;
  std::string TypeInfo() const override { return "VertexReferencePose"; }

 private:
  Qd q0_;
  Vec3 p0_;
};

/// Velocity of B in W [m/s], accelerometer bias [m/s²] and gyroscope bias [rad/s], stored [v, b_a, b_g].
class VertexSpeedBias : public SizedVertex<9, 9> {
 public:
  VertexSpeedBias();
  explicit VertexSpeedBias(const Vec9& v_ba_bg);
  VecX Minus(const VecX& x0) const final;
  void MinusInto(const VecX& x0, double* delta, double* derivative) const final;
  Vec3 v() const { return x_.head<3>(); }
  Vec3 b_a() const { return x_.segment<3>(3); }
  Vec3 b_g() const { return x_.tail<3>(); }
  std::string TypeInfo() const override { return "VertexSpeedBias"; }
};

/// 1/depth [1/m] of a landmark in the camera frame of its host.
class VertexInverseDepth : public SizedVertex<1, 1> {
 public:
  explicit VertexInverseDepth(double inverse_depth);
  double InverseDepth() const { return x_[0]; }
  std::string TypeInfo() const override { return "VertexInverseDepth"; }
};

/// A landmark's coordinates [m] in the world frame.
class VertexPointXYZ : public SizedVertex<3, 3> {
 public:
  explicit VertexPointXYZ(const Vec3& p_W);
  std::string TypeInfo() const override { return "VertexPointXYZ"; }
};

/// A landmark that may be far away. A step along the ray from the anchor c changes 1/distance evenly, one across it the
/// direction:
///
///   v = x − c,   q = vᵀδ / vᵀv,   x ← c + (v + δ − q v) / (1 − q)
///
/// To first order that is x + δ, so the Jacobians are those of VertexPointXYZ. But images of a distant point are nearly
/// linear in 1/distance, and not in the distance: steps may be longer, and the point reaches infinity in a few of them.
/// One step takes it 20 times as far at most. Source: Civera, Davison, Montiel, T-RO 2008, on inverse depth.
class VertexPointOnRay : public VertexPointXYZ {
 public:
  /// @param anchor  in W [m]; of the cameras that see the point the farthest is best, since its q is the smallest
  VertexPointOnRay(const Vec3& p_W, const Vec3& anchor);

  void Plus(const double* delta) override;
  std::string TypeInfo() const override { return "VertexPointOnRay"; }

 private:
  Vec3 anchor_;
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

  explicit VertexCameraBAL(const Vec9& camera);

  void Plus(const double* delta) override;
  /// Worked out once a step for all observations, and kept for the step's undoing; `other` holds the answer where ω has
  /// been changed by other means.
  const Rotation& GetRotation(Rotation* other) const;
  std::string TypeInfo() const override { return "VertexCameraBAL"; }

 private:
  Rotation rotation_, before_;  // of the present ω, of that before the last step
};

}  // namespace ch5
