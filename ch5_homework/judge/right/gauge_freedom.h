#pragma once
/// Stage 4, as the handout writes it.

#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework::right {

/// 4a: the rows of a pose at (p, R); ω moves along `axes`.
struct PoseRows {
  Formula dp_dt, dp_domega, dtheta_domega;

  PoseRows(const Vec3& p, const Mat33& R, const MatXX& axes);
};

/// 4b: of a velocity.
Formula VelocityTurned(const Vec3& v, const MatXX& axes);

/// 4c: Q = I − U (VᵀU)⁻¹ Vᵀ
Formula Projection(const MatXX& U, const MatXX& V);

/// 4d: the rows of one vertex in ∂θ_C/∂θ, whose first three are expressed in the world unless it has fewer.
Formula MotionRows(const Mat33& R_z, int row, int dim, int columns);

/// 4e: T Cov Tᵀ, T = Q_C ∂θ_C/∂θ
Formula OfOtherGauge(const MatXX& covariance, const MatXX& motion, const MatXX& Q, const MatXX& Q_C);

}  // namespace ch5::homework::right
