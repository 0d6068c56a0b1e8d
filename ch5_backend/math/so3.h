#pragma once
/// The rotation group SO(3): exponential, logarithm and their Jacobians.
///
/// Right perturbation throughout:  R ← R Exp(δθ).  Angles in radians.
/// Source: Forster et al., "On-Manifold Preintegration", TRO 2017, eqs. 3–9; Solà, "Quaternion kinematics".

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// The cross-product matrix:  Hat(a) b = a × b.
inline Mat33 Hat(const Vec3& a) {
  Mat33 A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

/// A [b] for a 2×3 matrix A: each row aᵀ[b] = (a × b)ᵀ, with two thirds of the multiplications.
inline Mat23 RowsCross(const Mat23& A, const Vec3& b) {
  Mat23 C;
  C.col(0) = A.col(1) * b.z() - A.col(2) * b.y();
  C.col(1) = A.col(2) * b.x() - A.col(0) * b.z();
  C.col(2) = A.col(0) * b.y() - A.col(1) * b.x();
  return C;
}

/// Exp: rotation vector θ (3×1, rad) → unit quaternion. Exact for any angle.
Qd ExpSO3(const Vec3& theta);

/// Log: unit quaternion → rotation vector with ‖θ‖ ≤ π; q and −q give the same θ.
Vec3 LogSO3(const Qd& q);

/// The shortest rotation R that makes a point where b does:  R a ∥ b.  a, b 3×1, not zero; half a turn about some axis
/// across a if they are opposite.
Qd RotationBetween(const Vec3& a, const Vec3& b);

/// J_l(θ) = I + (1−cos θ)/θ² [θ] + (θ−sin θ)/θ³ [θ]²:  Exp(θ+δ) ≈ Exp(J_l δ) Exp(θ).
Mat33 LeftJacobianSO3(const Vec3& theta);

/// J_r(θ) = J_l(−θ):  Exp(θ+δ) ≈ Exp(θ) Exp(J_r δ).
inline Mat33 RightJacobianSO3(const Vec3& theta) { return LeftJacobianSO3(-theta); }

/// J_r⁻¹(θ) = I + ½[θ] + (1/θ² − cot(θ/2)/(2θ)) [θ]²:  Log(Exp(θ) Exp(δ)) ≈ θ + J_r⁻¹ δ, for ‖θ‖ < 2π.
Mat33 RightJacobianInverseSO3(const Vec3& theta);

/// A rigid transform as plain values, q a unit quaternion and p in meters.
struct Transform {
  Qd q = Qd::Identity();
  Vec3 p = Vec3::Zero();
};

}  // namespace ch5
