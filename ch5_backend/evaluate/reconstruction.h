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

/// The estimate, moved onto the truth by the similarity of its camera centers, as tools for trajectories do. Points are
/// moved along but have no say: a wrong point must not make a right camera look wrong.
/// @return nullopt if the centers are fewer than three, on one line or not finite
/// @throws std::invalid_argument if the sizes differ
std::optional<Reconstruction> AlignToTruth(const Reconstruction& estimate, const Reconstruction& truth);

/// Errors without alignment.
/// @throws std::invalid_argument if the sizes differ
Rmse Compare(const Reconstruction& estimate, const Reconstruction& truth);

/// Errors without what the gauge leaves open: cameras after AlignToTruth, points after the similarity of the points.
/// @return nullopt if one of the two is not determined
/// @throws std::invalid_argument if the sizes differ
std::optional<Rmse> CompareAligned(const Reconstruction& estimate, const Reconstruction& truth);

}  // namespace ch5
