#include "ch5_backend/simulate/sensors/visual_inertial_ba.h"

#include <algorithm>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/simulate/sensors/imu_simulator.h"
#include "ch5_backend/simulate/sensors/scene_points.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5 {
namespace {

constexpr double kNear = 2.0, kFar = 6.0, kNearest = 0.3;  // depths of random points, and of anything seen [m]

void Check(const VisualInertialOptions& o) {
  CheckOption("VisualInertialOptions::keyframes", o.keyframes, 2);
  CheckOption("VisualInertialOptions::num_points", o.num_points, 1);
  CheckPositive("VisualInertialOptions::pixel_sigma", o.pixel_sigma);
  CheckNotNegative("Perturbation::position", o.start.position);
  CheckNotNegative("Perturbation::rotation", o.start.rotation);
  CheckNotNegative("Perturbation::velocity", o.start.velocity);
  CheckNotNegative("Perturbation::point", o.start.point);
}

// The point's position in the image [px], if it is visible.
std::optional<Vec2> Project(const Calibration& calibration, const Transform& T_W_B, const Vec3& p_W) {
  const Transform& T_B_C = calibration.T_B_C;
  const Vec3 p_C = T_B_C.q.conjugate() * (T_W_B.q.conjugate() * (p_W - T_W_B.p) - T_B_C.p);
  if (p_C.z() < kNearest) return std::nullopt;
  const Vec2 pixel = calibration.Pixel(p_C.hnormalized());
  return calibration.Contains(pixel) ? std::optional<Vec2>(pixel) : std::nullopt;
}

// Points that enough keyframes see, each with its pixels [keyframe, pixel].
void AddPoints(const Trajectory& path, const VisualInertialOptions& o, Random* random, VisualInertialScene* scene) {
  while (static_cast<int>(scene->points.size()) < o.num_points) {
    const std::vector<Vec3> candidate = o.points == GaugePoints::kPlanes
                                            ? PointsOnPlanes(GaugePaperPlanes(), 1, random)
                                            : PointsAlongPath(path, scene->calibration, kNear, kFar, 1, random);
    std::vector<VisualInertialScene::Observation> seen;
    for (size_t i = 0; i < scene->truth.size(); ++i) {
      const auto pixel = Project(scene->calibration, scene->truth[i].T_W_B, candidate[0]);
      if (pixel) seen.push_back({static_cast<int>(i), static_cast<int>(scene->points.size()), *pixel});
    }
    if (static_cast<int>(seen.size()) < std::min(o.min_views, o.keyframes)) continue;
    scene->points.push_back(candidate[0]);
    for (auto& observation : seen) {
      observation.u = scene->calibration.Normalized(observation.u + NormalVector<2>(random, o.pixel_sigma));
      scene->observations.push_back(observation);
    }
  }
}

}  // namespace

Calibration GaugeCamera() {
  Calibration calibration = ForwardCamera();
  calibration.T_B_C.p.setZero();
  calibration.fx = calibration.fy = 320.0;
  calibration.width = 640;
  calibration.height = 480;
  calibration.cx = 320.0;
  calibration.cy = 240.0;
  calibration.noise = {1.6e-2, 1.6e-3, 1e-6, 1e-7, /*continuous=*/true};  // biases do not move
  return calibration;
}

VisualInertialScene SimulateVisualInertial(const VisualInertialOptions& o) {
  Check(o);
  VisualInertialScene scene;
  scene.calibration = GaugeCamera();
  scene.pixel_sigma = o.pixel_sigma;
  const Trajectory path = GaugePaperPath(o.path);
  ImuOptions imu_options;
  imu_options.b_a.setZero();
  imu_options.b_g.setZero();
  imu_options.seed = 3 * o.seed;
  Calibration without_walk = scene.calibration;
  without_walk.noise.accelerometer_walk = without_walk.noise.gyroscope_walk = 0.0;
  const SimulatedImu imu = SimulateImu(path, without_walk, imu_options);
  for (int i = 0; i < o.keyframes; ++i) {
    const double t = path.Duration() * i / (o.keyframes - 1);
    const Motion motion = path.At(t);
    scene.truth.push_back({t, motion.T_W_B, motion.v_W, Vec3::Zero(), Vec3::Zero()});
  }
  for (int i = 0; i + 1 < o.keyframes; ++i) {
    const std::vector<ImuSample> samples = SamplesBetween(imu.measurements, scene.truth[i].t, scene.truth[i + 1].t);
    scene.imu.push_back(std::make_shared<Preintegration>(samples, Vec3::Zero(), Vec3::Zero(), scene.calibration.noise));
  }
  Random random(3 * o.seed + 1);
  AddPoints(path, o, &random, &scene);
  PerturbStart(o.start, 3 * o.seed + 2, &scene);
  return scene;
}

void PerturbStart(const Perturbation& start, uint64_t seed, VisualInertialScene* scene) {
  Random random(seed);
  scene->initial = scene->truth;
  for (StampedState& state : scene->initial) {
    state.T_W_B.p += NormalVector(&random, start.position);
    state.T_W_B.q = state.T_W_B.q * ExpSO3(NormalVector(&random, start.rotation));
    state.v_W += NormalVector(&random, start.velocity);
  }
  scene->initial_points = scene->points;
  for (Vec3& point : scene->initial_points) point += NormalVector(&random, start.point);
}

VisualInertialBa BuildVisualInertial(const VisualInertialScene& scene) {
  VisualInertialBa problem;
  for (const StampedState& state : scene.initial) {
    if (problem.poses.empty()) {
      problem.first = std::make_shared<VertexReferencePose>(state.T_W_B.q, state.T_W_B.p);
      problem.poses.push_back(problem.first);
    } else {
      problem.poses.push_back(std::make_shared<VertexPose>(state.T_W_B.q, state.T_W_B.p));
    }
    problem.graph.AddVertex(problem.poses.back());
    Vec9 v_ba_bg;
    v_ba_bg << state.v_W, state.b_a, state.b_g;
    problem.speed_biases.push_back(std::make_shared<VertexSpeedBias>(v_ba_bg));
    problem.graph.AddVertex(problem.speed_biases.back());
  }
  for (const Vec3& point : scene.initial_points) {
    problem.points.push_back(std::make_shared<VertexPointXYZ>(point));
    problem.graph.AddVertex(problem.points.back());
  }
  const Mat22 W = std::pow(scene.calibration.fx / scene.pixel_sigma, 2) * Mat22::Identity();
  for (const auto& observation : scene.observations) {
    auto edge = std::make_shared<EdgeReprojectionXYZ>(
        problem.points[observation.point], problem.poses[observation.keyframe], observation.u, scene.calibration.T_B_C);
    edge->SetInformation(W);
    problem.graph.AddEdge(edge);
  }
  const Vec3 reaction = -scene.calibration.GravityInWorld();
  for (size_t i = 0; i < scene.imu.size(); ++i) {
    problem.graph.AddEdge(std::make_shared<EdgeImu>(problem.poses[i], problem.speed_biases[i], problem.poses[i + 1],
                                                    problem.speed_biases[i + 1], scene.imu[i], reaction));
  }
  return problem;
}

std::vector<StampedState> KeyframesOf(const VisualInertialScene& scene, const VisualInertialBa& problem) {
  std::vector<StampedState> states = scene.truth;
  for (size_t i = 0; i < states.size(); ++i) {
    const VertexPose& pose = *problem.poses[i];
    const VertexSpeedBias& speed_bias = *problem.speed_biases[i];
    states[i] = {states[i].t, {pose.q(), pose.p()}, speed_bias.v(), speed_bias.b_a(), speed_bias.b_g()};
  }
  return states;
}

}  // namespace ch5
