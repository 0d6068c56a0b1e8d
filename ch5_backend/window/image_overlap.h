#pragma once
/// How much of an older image's landmarks a new image still sees: OKVIS's criterion for keyframes.

#include <vector>

#include "ch5_backend/math/array_memory.h"
#include "ch5_backend/window/window.h"

namespace ch5 {

/// Area of the convex hull; 0 with fewer than three points.
double HullArea(Array<Vec2> points);

/// The points of the newer image that the older image saw too.
struct ImageOverlap {
  double hull_ratio = 0.0;   ///< area of their convex hull / that of all points
  double match_ratio = 0.0;  ///< their number / that of all points
  double angle = 0.0;        ///< between the directions, in the world, in which the two images see a point; mean [rad]
};

/// @param older, newer  ids of frames of the window
ImageOverlap ImageOverlapOf(const Window& window, int older, int newer);

}  // namespace ch5
