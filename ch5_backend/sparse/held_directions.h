#pragma once
/// A part of a vertex that stays as it is, such as position and yaw of a pose, or biases.

#include <functional>
#include <memory>

#include "ch5_backend/graph/vertex.h"

namespace ch5 {

/// Directions in which a vertex is held, C δ = 0.
struct HeldDirections {
  std::shared_ptr<Vertex> vertex;  ///< not a landmark
  std::function<MatXX()> rows;     ///< C at the present states, k×LocalDimension(), of rank k ≥ 1
};

}  // namespace ch5
