#include "ch5_backend/experiments/studies/consistency_flight.h"

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/simulate/sensors/scene_points.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

constexpr double kPixelSigma = 1.0;

ObservabilityConstraints ConstraintsOf(const ConsistencyCase& c) {
  if (c.mode == "none") return ObservabilityConstraints::kNone;
  return c.mode == "full" ? ObservabilityConstraints::kAllEdges : ObservabilityConstraints::kMarginalizedEdges;
}

// σ of the first state, both for the draw and in the prior. The σ of the speed is large since its direction in W would
// reveal yaw.
struct StartSigma {
  double position = 0.01;  // [m]
  double yaw = 0.05;       // [rad]
  double tilt = 0.01;      // roll and pitch [rad]
  double speed = 0.2;      // [m/s]
  double b_a = 0.02;       // [m/s²]
  double b_g = 0.002;      // [rad/s]
};

// Square root of the first state's information, over [δp, δθ, v, b_a, b_g]: yaw is about W's z axis. Without
// position and yaw the direction of the speed is unknown too.
MatXX StartInformation(const StartSigma& sigma, const Qd& q_W_B, bool with_position_and_yaw) {
  MatXX J = MatXX::Zero(15, 15);
  if (with_position_and_yaw) J.diagonal().head<3>().setConstant(1.0 / sigma.position);
  const Vec3 rotation(1.0 / sigma.tilt, 1.0 / sigma.tilt, with_position_and_yaw ? 1.0 / sigma.yaw : 0.0);
  J.block<3, 3>(3, 3) = rotation.asDiagonal() * q_W_B.toRotationMatrix();
  if (with_position_and_yaw) J.diagonal().segment<3>(6).setConstant(1.0 / sigma.speed);
  J.diagonal().segment<3>(9).setConstant(1.0 / sigma.b_a);
  J.diagonal().segment<3>(12).setConstant(1.0 / sigma.b_g);
  return J;
}

// Circles of 3 m radius in a room, 12 s a lap, going up and down and swaying a little.
Trajectory Circle(double duration, double heading) {
  const auto formula = [heading](const Jet& t) {
    const Jet angle = (2.0 * M_PI / 12.0) * t;
    const Jet radius = 3.0 + 0.3 * Sin(1.3 * t);
    return Coordinates{{radius * Cos(angle), radius * Sin(angle), 0.4 * Sin(0.9 * t)},
                       angle + heading + 0.2 * Sin(0.7 * t),
                       0.1 * Sin(0.8 * t),
                       0.1 * Sin(1.1 * t)};
  };
  return Trajectory(formula, duration);
}

}  // namespace

Recording ConsistencyFlight(const ConsistencyOptions& options, int run) {
  Random scene(3);
  SimulationOptions simulation;
  simulation.calibration.camera_rate = options.camera_rate;
  simulation.calibration.imu_rate = 100.0;
  simulation.camera.pixel_sigma = kPixelSigma;
  simulation.camera.max_tracks = options.max_tracks;
  simulation.camera.drop_probability = 0.05;
  simulation.imu.seed = 1000 + static_cast<uint64_t>(run);
  simulation.camera.seed = 2000 + static_cast<uint64_t>(run);
  return SimulateRecording(Circle(options.seconds, options.heading),
                           PointsOnPlanes(RoomWalls({-6, -6, -3}, {6, 6, 3}), 600, &scene), simulation);
}

DrawnStart DrawStart(const StampedState& truth, int run) {
  const StartSigma sigma;
  Random random(3000 + static_cast<uint64_t>(run));
  StampedState state = truth;
  state.T_W_B.p += NormalVector(&random, sigma.position);
  const Vec3 tilt = NormalVector(&random, sigma.tilt);
  const double yaw = sigma.yaw * random.Normal();
  state.T_W_B.q = ExpSO3(Vec3(tilt.x(), tilt.y(), yaw)) * state.T_W_B.q;
  state.v_W += NormalVector(&random, sigma.speed);
  state.b_a += NormalVector(&random, sigma.b_a);
  state.b_g += NormalVector(&random, sigma.b_g);
  return {state, StartInformation(sigma, state.T_W_B.q, true), StartInformation(sigma, state.T_W_B.q, false)};
}

EstimatorOptions ConsistencyEstimator(const ConsistencyCase& c, const Calibration& calibration) {
  EstimatorOptions options{calibration};
  if (c.hosts != "published") {
    options.weights.pixel_sigma = kPixelSigma;
    options.weights.cauchy = 0.0;
  }
  options.weights.noisy_hosts = c.hosts == "noisy";
  options.max_outlier_pixels = 5.0 * kPixelSigma;  // the simulated tracks have no outliers, only depths diverge
  options.max_rejecting = 1e9;                     // few landmarks are normal here
  options.observability_constraints = ConstraintsOf(c);
  options.report_covariance = true;
  return options;
}

std::unique_ptr<WindowPolicy> ConsistencyPolicy(const ConsistencyCase& c) {
  VinsOptions vins;
  vins.window_size = 6;
  vins.reuse_observations = c.observations == "twice";
  OkvisOptions okvis{/*keyframes=*/3, /*temporal_frames=*/4};
  vins.cost_tolerance = okvis.cost_tolerance = 1e-6;
  vins.max_iterations = okvis.max_iterations = 20;
  return c.policy == "okvis" ? MakeOkvisPolicy(okvis) : MakeVinsPolicy(vins);
}

}  // namespace ch5
