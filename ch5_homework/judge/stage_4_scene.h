#pragma once
/// The scenes and the oracles of stage 4. What the world's motion does to a state is computed by moving it, and
/// differentiated numerically; covariances are computed in each gauge on its own. Nothing here uses the submission.

#include <string>
#include <vector>

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/scenes.h"

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

/// Columns of U: "x", …, "yaw"; and its rows: "VertexPose 2, δθ.z", the number being the place in the list.
Names DirectionNames(GaugeGroup group);
Names RowNames(const Vertices& vertices);
Text NameOf(GaugeGroup group);

/// e_z, or e_z, e_x, e_y, as columns.
MatXX AxesOf(GaugeGroup group);

/// Central differences with step 1e-5: exact to about 1e-9.
MatXX NumericNullSpace(const Vertices& vertices, GaugeGroup group);
MatXX NumericMotionJacobian(const Vertices& vertices, const Motion& g);

std::shared_ptr<VertexPose> RandomPose(Random* random);
std::shared_ptr<VertexSpeedBias> RandomSpeedBias(Random* random);
std::shared_ptr<VertexPointXYZ> RandomPoint(Random* random);
/// Each type at least once, in random order.
Vertices RandomVertices(int count, Random* random);

/// A few frames that see points and an inverse depth; with an IMU between them if the group is the visual-inertial one.
/// The states are not those of a minimum, and need not be: H U = 0 holds everywhere.
struct FreeScene {
  Graph graph;
  Vertices vertices;  ///< in the order of H's rows
  FreeScene(GaugeGroup group, int frames, int points, uint64_t seed);

  /// H at the present states.
  MatXX Hessian() const;
  /// The gauge of the first frame: its position and yaw; without IMU all of its pose, and p_1 along p_1 − p_0.
  MatXX FirstFrame(GaugeGroup group) const;

 private:
  void AddImu(Random* random);
};

/// The pseudo-inverse of H, whose `nullity` smallest eigenvalues are taken for zero.
MatXX FreeCovariance(const MatXX& H, int nullity);
/// E[δ δᵀ] of the problem that knows Vᵀδ = 0:  N (Nᵀ H N)⁻¹ Nᵀ,  N a basis of these δ.
MatXX FixedCovariance(const MatXX& H, const MatXX& V);
/// An orthonormal basis of {δ: Vᵀδ = 0}, n×(n − columns of V).
MatXX Complement(const MatXX& V);

}  // namespace ch5::homework
