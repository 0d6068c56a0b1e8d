#pragma once
/// The directions of the gauge: the motions of the whole world that no measurement can observe.
///
/// For a motion x ↦ g(ε)·x of all vertices the direction is  n = ∂(g(ε)·x ⊟ x)/∂ε,  taken here by central differences
/// of the group's action on each vertex. The observability constraints write four of them out by hand
/// (observability.cc); a test checks one against the other.

#include <memory>
#include <string>
#include <vector>

#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

enum class GaugeGroup {
  kVisualInertial,  ///< x, y, z, yaw: gravity fixes roll and pitch, the accelerometer fixes the scale
  kMonocular        ///< x, y, z, yaw, roll, pitch, scale
};

struct GaugeOptions {
  GaugeGroup group = GaugeGroup::kVisualInertial;
  std::vector<const Vertex*> local_poses;       ///< poses that are not expressed in W, such as an extrinsic
  const Prior* linearization_points = nullptr;  ///< take n at this prior's x₀, as EdgeFirstEstimate does; null: at x
};

/// Names of the directions, in the order of the columns of GaugeDirections.
std::vector<std::string> GaugeDirectionNames(GaugeGroup group);

/// The directions n as columns. A unit is 1 m, 1 rad about an axis of W, or a scale by the factor e. Rotations and scale
/// are about the mean position of the poses.
/// @return Σ LocalDimension × 4 (visual-inertial) or × 7 (monocular), rows in the order of the vertices
MatXX GaugeDirections(const std::vector<std::shared_ptr<Vertex>>& vertices, const GaugeOptions& options);

}  // namespace ch5
