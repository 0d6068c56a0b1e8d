#pragma once
/// Colored points as PLY text, which MeshLab, CloudCompare and Blender open.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

struct ColoredPoint {
  Vec3 p;
  std::array<uint8_t, 3> rgb;
};

/// The points as PLY text.
std::string FormatPly(const std::vector<ColoredPoint>& points);

}  // namespace ch5
