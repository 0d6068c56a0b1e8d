#pragma once
/// The freedom of the gauge (homework, stage 4): motions of the whole world change no residual,
///
///   J(θ) = J(g(θ)),   g: x ↦ s R x + t      R = R_z for a camera with an IMU, any R and s > 0 for a camera alone
///
///   4a, 4b  U = ∂(g(θ) ⊟ θ)/∂g at g = 1                the null space of H
///   4c      Q = I − U (VᵀU)⁻¹ Vᵀ                       moves δ along U until Vᵀδ = 0
///   4d, 4e  Cov_C = (Q_C ∂θ_C/∂θ) Cov (Q_C ∂θ_C/∂θ)ᵀ   the covariance of the gauge Vᵀδ = 0, Q_C being Q at θ_C
///
/// Source: Zhang, Gallego, Scaramuzza, "On the Comparison of Gauge Freedom Handling in Optimization-based
/// Visual-Inertial State Estimation", RA-L 2018, §III and §VI, eqs. 12–15; here with right perturbations R Exp(δθ),
/// which no rotation of the world changes.

#include <memory>
#include <vector>

#include "ch5_backend/graph/vertex.h"

namespace ch5 {

/// The unknowns whose rows a matrix has, in its order.
using Vertices = std::vector<std::shared_ptr<Vertex>>;

/// What no measurement determines.
enum class GaugeGroup {
  kVisualInertial,  ///< t and yaw: gravity fixes roll and pitch, the accelerometer fixes the scale
  kMonocular        ///< t, yaw, roll, pitch, scale
};

/// 4 or 7.
inline int NumGaugeDirections(GaugeGroup group) { return group == GaugeGroup::kVisualInertial ? 4 : 7; }

/// Σ LocalDimension: the rows of all below.
int TotalLocalDimension(const Vertices& vertices);

/// U at the present states. Rows in the order of the vertices, which are all expressed in W. Columns: x, y, z, yaw and, for
/// a camera alone, roll, pitch, scale; units 1 m, 1 rad about W's origin and axes, and a scale by the factor e.
/// @return TotalLocalDimension × 4 or 7; rows of biases and of unknown types are zero
MatXX GaugeNullSpace(const Vertices& vertices, GaugeGroup group);

/// (VᵀU)⁻¹, 4×4 or 7×7.
/// @throws std::invalid_argument if VᵀU is singular: V does not hold the gauge
MatXX InverseOfVtU(const MatXX& U, const MatXX& V);

/// Q, the projection along U onto Vᵀδ = 0.
/// @param V  n×4 or n×7; V = U gives the δ of smallest norm, hence the pseudo-inverse's (free) gauge
/// @throws std::invalid_argument as InverseOfVtU
MatXX GaugeProjection(const MatXX& U, const MatXX& V);

/// ∂θ_C/∂θ of the motion θ_C = R_z(yaw) θ + t: R_z for positions, velocities and points; the identity for the rest, as
/// R_z R Exp(δθ) has the δθ of R Exp(δθ).
/// @param yaw  [rad];  @return square, block diagonal
MatXX GaugeMotionJacobian(const Vertices& vertices, double yaw);

/// Cov_C out of Cov: from a free gauge to a fixed one, back, or between any two.
/// @param covariance  n×n, of θ in any gauge;  @param motion  ∂θ_C/∂θ
/// @param Q, Q_C  for the gauge that is wanted, at θ and at θ_C: Q_C ∂θ_C/∂θ = ∂θ_C/∂θ Q, so either will do
MatXX TransformCovariance(const MatXX& covariance, const MatXX& motion, const MatXX& Q, const MatXX& Q_C);

}  // namespace ch5
