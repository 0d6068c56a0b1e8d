#pragma once
/// Observations of landmarks by inverse depth, side by side: the equations of edge_reprojection.h,
/// edge_reprojection_calibration.h and edge_stereo.h for eight at a time.
///
/// Edges with the same host, target and cameras share T_Cj_Ci = T_W_Cj⁻¹ T_W_Ci, which is worked out once a pair. Scaled by
/// λ, no distance is left to divide by: with f = [u_i, v_i, 1]
///   q = λ p_Cj = R_Cj_Ci f + λ p_Cj_Ci,   [x, y] = [q_x, q_y]/q_z,   ∂r/∂q = G/q_z,   G = [1 0 −x; 0 1 −y]
/// All poses enter through T_Cj_Ci only: with ξ = [δt; φ] of RelativeJacobian (graph/fast_edge.h)
///   J_λ = G/q_z p_Cj_Ci,   J_ξ = G/q_z [λ I  −[R_Cj_Ci f]]

#include <vector>

#include "ch5_backend/types/visual/edge_reprojection_calibration.h"

namespace ch5 {

/// A rotation (row-major) and a position.
struct RigidNumbers {
  double R[9], p[3];
};
static_assert(sizeof(RigidNumbers) == 12 * sizeof(double));

/// A point of each edge; all but x only where the camera's clock is a vertex.
struct MovingPoints {
  std::vector<double> x[2], velocity[2], clock_offset;

  void Add(const Vec2& point) {
    for (int i = 0; i < 2; ++i) x[i].push_back(point[i]);
  }
  void Add(const MovingPoint& point) {
    Add(point.x);
    for (int i = 0; i < 2; ++i) velocity[i].push_back(point.velocity[i]);
    clock_offset.push_back(point.clock_offset);
  }
  void Clear() {
    for (auto* numbers : {&x[0], &x[1], &velocity[0], &velocity[1], &clock_offset}) numbers->clear();
  }
};

/// What edges with the same vertices, but for the inverse depth, have in common: numbers of poses and of cameras.
struct ReprojectionPair {
  int host, target, camera_i, camera_j;
};

struct Reprojections {
  std::vector<ReprojectionPair> pairs;
  std::vector<RigidNumbers> T_Cj_Ci;  ///< of each pair
  std::vector<int> pair;              ///< of each edge, as all below
  std::vector<const VertexInverseDepth*> inverse_depth;
  std::vector<const VertexScalar*> time_offset;  ///< none where the camera's clock is no vertex
  MovingPoints host, target;
};

/// r of edges [first, first + count), count ≤ kPack, as one pack (graph/fast_edge.h).
void ComputeResiduals(const Reprojections& seen, int first, int count, double* r);
/// The same, J_λ and J_ξ.
void Linearize(const Reprojections& seen, int first, int count, double* r, double* J);

}  // namespace ch5
