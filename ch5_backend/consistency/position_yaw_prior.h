#pragma once
/// The gauge prior of a window: position and yaw, which no measurement observes, are held at a frame.

#include <memory>

#include "ch5_backend/graph/edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

/// Holds position and yaw of a pose at their present values; pitch and roll stay free, since gravity observes them.
/// @param information  of each of the four directions [1/m², 1/rad²]
std::shared_ptr<Edge> MakePositionYawPrior(const std::shared_ptr<VertexPose>& pose, double information);

}  // namespace ch5
