#pragma once
/// The result of a bundle adjustment, and its error after alignment with the truth.

#include "ch5_backend/evaluate/align.h"
#include "ch5_backend/simulate/mono_ba.h"

namespace ch5 {

/// Camera poses T_W_C and points p_W [m].
struct Reconstruction {
  std::vector<Transform> frames;
  std::vector<Vec3> points;
};

/// √(mean ‖error‖²) of positions [m], rotations [rad] and points [m].
struct Rmse {
  double position = 0.0;
  double rotation = 0.0;
  double point = 0.0;
};

/// The scene's true poses and points.
Reconstruction TruthOf(const MonoBaScene& scene);
/// The present states of the vertices; a point is p_W = R_0 [u, v, 1]/λ + p_0, seen from its host, frame 0.
Reconstruction EstimateOf(const MonoBaScene& scene, const MonoBa& problem);

/// The estimate, moved onto the truth by the similarity of all its camera centers and points together.
/// @throws std::invalid_argument if the sizes differ or the alignment is not determined
Reconstruction AlignToTruth(const Reconstruction& estimate, const Reconstruction& truth);

/// Errors without alignment: call AlignToTruth first to exclude the gauge.
/// @throws std::invalid_argument if the sizes differ
Rmse Compare(const Reconstruction& estimate, const Reconstruction& truth);

}  // namespace ch5
