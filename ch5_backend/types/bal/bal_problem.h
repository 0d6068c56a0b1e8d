#pragma once
/// A "Bundle Adjustment in the Large" problem as plain values (Agarwal et al., ECCV 2010).

#include <string>
#include <vector>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

/// Where a camera saw a point.
struct BalObservation {
  int camera;
  int point;
  Vec2 pixel;  ///< [px, y up]
};

/// A problem: its observations, and all unknowns at their start. Cameras are [ω, t, f, k₁, k₂], see VertexCameraBAL, points X_W.
struct BalProblem {
  std::vector<BalObservation> observations;
  std::vector<Vec9> cameras;
  std::vector<Vec3> points;
  std::string unended;     ///< of TextReader::UnendedLine, if it is read from a file
  std::vector<int> lines;  ///< where each observation stands, if they are read from a file
};

}  // namespace ch5
