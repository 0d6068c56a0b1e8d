#pragma once
/// The course's scene (TestMonoBA): a camera on a quarter circle of radius 8 m looks at a box of points.
///
///   θ_n = 2π n / (4 N),   R_W_C = R_z(θ_n),   p_W_C = (8 cos θ − 8, 8 sin θ, sin 2θ)      camera = body
///   points x, y ∈ [−4, 4), z ∈ [4, 8);  pixels on the plane z = 1, σ = 1/1000;  frame 0 hosts every landmark

#include <memory>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5 {

struct MonoBaOptions {
  int frames = 3;
  int points = 20;
  double pixel_sigma = 1e-3;    ///< noise of every observation, the host's too [normalized plane]
  double depth_sigma = 1.0;     ///< initial depth = true depth + noise, truncated at ±3σ [m]
  double position_sigma = 0.0;  ///< perturbation of the starting poses [m]; the course starts at the truth
  double rotation_sigma = 0.0;  ///< likewise [rad]
  uint64_t seed = 5;
};

/// The simulated scene as plain values. Draws in a fixed order (points, observations, depths, poses), so that the
/// same seed gives the same points whatever the noise.
struct MonoBaScene {
  std::vector<Transform> frames;          ///< truth, T_W_C
  std::vector<Vec3> points;               ///< truth, p_W [m]
  std::vector<std::vector<Vec2>> pixels;  ///< [frame][point], normalized plane, with noise
  std::vector<Transform> initial_frames;
  std::vector<double> initial_inverse_depths;  ///< [1/m], in frame 0
};

/// @throws OptionError if frames < 2, points < 1, or a σ is negative or not finite
MonoBaScene SimulateMonoBa(const MonoBaOptions& options);

/// The scene as a graph, ready to be solved.
struct MonoBa {
  Graph graph;
  std::vector<std::shared_ptr<VertexPose>> poses;
  std::vector<std::shared_ptr<VertexInverseDepth>> landmarks;
};

/// How the gauge, 7 free directions of a monocular bundle adjustment, is held.
enum class Gauge { kFree, kFixTwoFrames, kPriorTwoFrames, kPriorMinimal };

/// The scene's vertices at their initial values, and its edges.
/// @param pixel_information  W = pixel_information·I₂ of each observation: 1 as in the course, or 1/σ²
/// @param prior_weight  of kPriorTwoFrames and kPriorMinimal, see AddMonoBaEdges; 0 leaves the gauge free
MonoBa BuildMonoBa(const MonoBaScene& scene, Gauge gauge, double pixel_information, double prior_weight);

/// Stage 3: one reprojection edge per landmark and frame ≥ 1, and, if `prior_weight` > 0, one EdgeSE3Prior with
/// information prior_weight·I₆ on each of the first two frames, at the frame's true pose.
void AddMonoBaEdges(const MonoBaScene& scene, double pixel_information, double prior_weight, MonoBa* problem);

/// The minimal gauge: a prior of `weight`·I₆ on frame 0 and of `weight` on frame 1's position along the baseline
/// only: 6 + 1 = 7 constraints for 7 free directions, so that the optimum's reprojection cost cannot depend on it.
void AddMinimalGaugePrior(const MonoBaScene& scene, double weight, MonoBa* problem);

}  // namespace ch5
