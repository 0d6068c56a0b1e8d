#pragma once
/// The constraint of observability: however far the states have moved since a prior was made, every edge takes the same
/// directions n for those that nothing measures, position and yaw, and none of them tells anything of n.
///
///   J' = J − J (N₀ − N) (N₀ᵀN₀)⁻¹ N₀ᵀ,     so that J'N₀ = J N, which is zero, and ‖J' − J‖ is least
///
/// N are the gauge's directions at the present states and N₀ those at the first estimates of the states that the prior
/// knows. First-estimate Jacobians (first_estimates.h) reach the same null space by linearising there altogether. They
/// also take over all that was not known well at first, such as scale; here only the null space is old.
/// Source: Hesch, Kottas, Bowman, Roumeliotis, "Consistency analysis and improvement of vision-aided inertial
/// navigation", TRO 2014, eq. 60.

#include "ch5_backend/consistency/first_estimates.h"

namespace ch5 {

/// An edge of poses, speeds and what does not live in W, with J' in place of J.
class EdgeObservabilityConstrained : public EdgeOtherJacobians {
 public:
  /// @param edge       not in any graph;  @param prior  must outlive this edge
  /// @param bystander  a pose that does not live in W, such as an extrinsic; null: none
  EdgeObservabilityConstrained(std::shared_ptr<Edge> edge, const Prior* prior, const Vertex* bystander);
  void ComputeJacobians() override;

 private:
  using Directions = Eigen::Matrix<double, Eigen::Dynamic, 4>;
  Directions DirectionsAt(const std::vector<const double*>& x, const Vec3& center) const;

  const Vertex* bystander_;
  std::vector<const double*> now_, first_;  // parameters of each vertex
};

/// The edge so constrained; itself if the prior knows none of its vertices.
std::shared_ptr<Edge> ConstrainObservability(std::shared_ptr<Edge> edge, const Prior& prior, const Vertex* bystander);

}  // namespace ch5
