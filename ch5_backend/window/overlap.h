#pragma once
/// How much a new image shows of what an older one saw: OKVIS's question before it makes a keyframe.

#include <vector>

#include "ch5_backend/window/window.h"

namespace ch5 {

/// Area of the convex hull; 0 with fewer than three points.
double HullArea(std::vector<Vec2> points);

struct Overlap {
  double hull = 0.0;     ///< hull of the points also seen in the older image / hull of all points
  double matches = 0.0;  ///< their number / the number of all points
};

/// @param older, newer  ids of frames of the window
Overlap OverlapOf(const Window& window, int older, int newer);

}  // namespace ch5
