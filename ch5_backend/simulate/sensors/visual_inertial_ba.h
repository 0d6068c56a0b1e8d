#pragma once
/// The problem of the gauge paper: keyframes on a path, points on planes or along the path, an IMU between the keyframes.
///
///   unknown: p, R, v of each keyframe and X of each point, n = 9 N + 3 K;   known: biases, extrinsic, gravity
///
/// Source: Zhang, Gallego, Scaramuzza, RA-L 2018, §V. What the paper leaves open (K, intrinsics, noise, rates) is chosen
/// here: see GaugeCamera and VisualInertialOptions.

#include <memory>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/simulate/sensors/paths.h"
#include "ch5_backend/types/inertial/preintegration.h"
#include "ch5_backend/types/recording.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

/// Where the points lie: on planes, or along the path.
enum class GaugePoints { kPlanes, kRandom };

/// The start's distance from the truth, σ per axis.
struct Perturbation {
  double position = 0.05;                ///< [m]
  double rotation = 6.0 * M_PI / 180.0;  ///< [rad]
  double velocity = 0.05;                ///< [m/s]
  double point = 0.075;                  ///< [m]
};

struct VisualInertialOptions {
  GaugePath path = GaugePath::kSine;
  GaugePoints points = GaugePoints::kPlanes;
  int keyframes = 10;
  int num_points = 60;
  int min_views = 4;         ///< keyframes that see a point at least; with two the path `rec` has points of no parallax
  double pixel_sigma = 1.0;  ///< [px]
  Perturbation start;
  uint64_t seed = 1;  ///< of points, noise and start
};

/// 640×480 pixels, f = 320 px, at the body's origin; an IMU of 200 Hz with 0.0016 rad/s/√Hz and 0.016 m/s²/√Hz.
Calibration GaugeCamera();

/// The problem as plain values.
struct VisualInertialScene {
  /// Where a keyframe sees a point.
  struct Observation {
    int keyframe, point;
    Vec2 u;  ///< normalized plane
  };

  Calibration calibration;
  double pixel_sigma = 1.0;                                ///< of the observations [px]
  std::vector<StampedState> truth;                         ///< of each keyframe
  std::vector<Vec3> points;                                ///< truth, p_W [m]
  std::vector<Observation> observations;                   ///< each point is seen by min_views keyframes at least
  std::vector<std::shared_ptr<const Preintegration>> imu;  ///< [i]: from keyframe i to i + 1, at the true biases
  std::vector<StampedState> initial;
  std::vector<Vec3> initial_points;
};

/// @throws OptionError if there are fewer than 2 keyframes or 1 point, or a σ is negative
VisualInertialScene SimulateVisualInertial(const VisualInertialOptions& options);

/// Sets `initial` and `initial_points`: the truth and noise.
void PerturbStart(const Perturbation& start, uint64_t seed, VisualInertialScene* scene);

/// The scene as a graph whose gauge is free, at its initial states.
struct VisualInertialBa {
  Graph graph;
  std::shared_ptr<VertexReferencePose> first;  ///< poses[0]
  std::vector<std::shared_ptr<VertexPose>> poses;
  std::vector<std::shared_ptr<VertexSpeedBias>> speed_biases;  ///< their biases are the true ones, to be held
  std::vector<std::shared_ptr<VertexPointXYZ>> points;
};

/// The scene's vertices, at their perturbed values, and its edges.
VisualInertialBa BuildVisualInertial(const VisualInertialScene& scene);

/// The present states, at the times of the truth.
std::vector<StampedState> KeyframesOf(const VisualInertialScene& scene, const VisualInertialBa& problem);

}  // namespace ch5
