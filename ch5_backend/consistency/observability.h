#pragma once
/// Observability constraints: however far the states have moved since the prior was made, all edges share the same four
/// unobservable directions, position and yaw, and none of them brings information along these.
///
///   J' = J − J (N₀ − N) (N₀ᵀN₀)⁻¹ N₀ᵀ,     so that J'N₀ = J N, which is zero, and ‖J' − J‖ is least
///
/// N holds the gauge's directions at the present states, N₀ those at the first estimates of the states in the prior.
/// First-estimate Jacobians reach the same null space by linearizing at the first estimates altogether, and so also keep what
/// was poorly known at first, such as scale; here only the null space is old.
/// Source: Hesch, Kottas, Bowman, Roumeliotis, "Consistency analysis and improvement of vision-aided inertial
/// navigation", TRO 2014, eq. 60.

#include <memory>
#include <vector>

#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

/// Which edges of a sliding window get observability constraints.
enum class ObservabilityConstraints {
  kNone,               ///< none: every edge is linearized at the present states (VINS-Mono)
  kMarginalizedEdges,  ///< those that are marginalized into the prior
  kAllEdges            ///< and those of the solve too
};

/// The directions x, y, z and yaw about `center` at any states; at the present ones, about the mean of the poses, these are
/// GaugeDirections (gauge_directions.h).
/// @param x            the parameters of each vertex
/// @param local_poses  poses that are not expressed in W, such as extrinsics
/// @return Σ LocalDimension × 4. Rows of poses and of speeds; all others are zero
Eigen::Matrix<double, Eigen::Dynamic, 4> PositionYawDirections(const std::vector<std::shared_ptr<Vertex>>& vertices,
                                                               const std::vector<const double*>& x,
                                                               const std::vector<const Vertex*>& local_poses,
                                                               const Vec3& center);

/// The edge with J' in place of J, whose residual, information and loss it shares; the edge itself if the prior holds none of
/// its vertices.
/// @param edge   on poses, speeds and biases, and vertices that are not expressed in W; must not be in any graph
/// @param prior  must outlive the result
std::shared_ptr<Edge> ConstrainObservability(std::shared_ptr<Edge> edge, const Prior& prior,
                                             const std::vector<const Vertex*>& local_poses);

}  // namespace ch5
