#pragma once
/// The oracles of stage 4. What the world's motion does to a state is computed by moving it, and
/// differentiated numerically; covariances are computed in each gauge on its own. Nothing here uses the submission.

#include <string>
#include <vector>

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/oracle.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

/// x ↦ s R x + t of the whole world.
struct Motion {
  double s = 1.0;
  Qd R = Qd::Identity();
  Vec3 t = Vec3::Zero();

  Vec3 operator*(const Vec3& x) const { return s * (R * x) + t; }
  void ActOn(Vertex* vertex) const;
};
void MoveAll(const Motion& g, const Vertices& vertices);

/// Columns of U: "x", …, "yaw".
Names DirectionNames(GaugeGroup group);
Text NameOf(GaugeGroup group);

/// e_z, or e_z, e_x, e_y, as columns.
MatXX AxesOf(GaugeGroup group);

/// By differences.
MatXX NumericNullSpace(const Vertices& vertices, GaugeGroup group);
MatXX NumericMotionJacobian(const Vertices& vertices, const Motion& g);

/// The scene "free graph", in which nothing holds the gauge.
struct FreeScene : GraphScene {
  FreeScene(GaugeGroup group, int frames, int points, int seed)
      : GraphScene("free graph", {static_cast<int>(group), frames, points, seed}) {}

  /// H at the present states.
  MatXX Hessian() const;
  /// The gauge of the first frame: its position and yaw; without IMU all of its pose, and p_1 along p_1 − p_0.
  MatXX FirstFrame(GaugeGroup group) const;
};

/// The pseudo-inverse of H, whose `nullity` smallest eigenvalues are taken for zero.
MatXX FreeCovariance(const MatXX& H, int nullity);
/// E[δ δᵀ] of the problem that knows Vᵀδ = 0:  N (Nᵀ H N)⁻¹ Nᵀ,  N a basis of these δ.
MatXX FixedCovariance(const MatXX& H, const MatXX& V);
/// Q by what it does: it takes U to zero, and leaves alone what satisfies Vᵀδ = 0.
MatXX ProjectionByItsEffect(const MatXX& U, const MatXX& V);
/// An orthonormal basis of {δ: Vᵀδ = 0}, n×(n − columns of V).
MatXX Complement(const MatXX& V);

}  // namespace ch5::homework
