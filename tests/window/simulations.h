#pragma once
/// Recordings for the estimators: a hand-held camera in a room.

#include <algorithm>
#include <cmath>

#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/simulate/sensors/scene_points.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {

constexpr double kDegree = M_PI / 180.0;

struct RoomOptions {
  double duration = 20.0;  // [s]
  double standstill_seconds = 2.0;
  int max_tracks = 60;
  SimulationOptions simulation = {};
  uint64_t seed = 1;
};

inline Recording SimulateRoom(RoomOptions options = {}) {
  HandheldOptions path;
  path.duration = options.duration;
  path.standstill_seconds = options.standstill_seconds;
  path.seed = options.seed;
  options.simulation.camera.max_tracks = options.max_tracks;
  return SimulateInRoom(path, 1500, options.simulation, options.seed);
}

/// In a hall of 16 by 16 by 8 m, with 60 tracks.
inline Recording SimulateInHall(const Trajectory& path, SimulationOptions options = {}) {
  Random random(1);
  options.camera.max_tracks = 60;
  return SimulateRecording(path, PointsOnPlanes(RoomWalls(Vec3(-8, -8, -4), Vec3(8, 8, 4)), 3000, &random), options);
}

/// 2 m/s on a level circle, looking ahead: the force is the same all the time, so that nothing tells a larger or smaller
/// circle from a bias of the accelerometer.
inline Recording SimulateCircle(double duration) {
  constexpr double kRadius = 3.0, kRate = 2.0 / kRadius;
  const Trajectory circle(
      [](const Jet& t) {
        const Jet angle = kRate * t;
        return Coordinates{{kRadius * Sin(angle), -kRadius * Cos(angle), {}}, angle, {}, {}};
      },
      duration);
  return SimulateInHall(circle);
}

/// 5 m/s straight ahead on a level road: nothing tells the scale.
inline Recording SimulateSteadyDrive(double duration) {
  const Trajectory road([](const Jet& t) { return Coordinates{{5.0 * t, {}, {}}, {}, {}, {}}; }, duration);
  Random random(1);
  SimulationOptions options;
  options.camera.max_tracks = 100;
  return SimulateRecording(road, PointsAlongPath(road, options.calibration, 3.0, 30.0, 3000, &random), options);
}

/// To the bit.
inline bool AreSame(const std::vector<StampedState>& a, const std::vector<StampedState>& b) {
  const auto same = [](const StampedState& x, const StampedState& y) {
    return x.t == y.t && x.T_W_B.p == y.T_W_B.p && x.T_W_B.q.coeffs() == y.T_W_B.q.coeffs() && x.v_W == y.v_W &&
           x.b_a == y.b_a && x.b_g == y.b_g;
  };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same);
}

}  // namespace ch5
