#pragma once
/// The directions of the gauge: the motions of the whole world that no measurement can observe.
///
/// Their formulas are in gauge_freedom.h; here they get names and turn about the middle of the poses, so that a leak along one
/// of them has a meaning.

#include <string>
#include <vector>

#include "ch5_backend/consistency/gauge_freedom.h"

namespace ch5 {

struct GaugeOptions {
  GaugeGroup group = GaugeGroup::kVisualInertial;
  std::vector<const Vertex*> local_poses;  ///< poses that are not expressed in W, such as an extrinsic
};

/// Names of the directions, in the order of the columns of GaugeDirections.
std::vector<std::string> GaugeDirectionNames(GaugeGroup group);

/// The directions n as columns. A unit is 1 m, 1 rad about an axis of W, or a scale by the factor e. Rotations and scale
/// are about the mean position of the poses.
/// @return Σ LocalDimension × 4 (visual-inertial) or × 7 (monocular), rows in the order of the vertices
MatXX GaugeDirections(const Vertices& vertices, const GaugeOptions& options);

}  // namespace ch5
