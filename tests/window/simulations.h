#pragma once
/// Recordings for the estimators: a hand-held camera in a room.

#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {

struct RoomOptions {
  double duration = 20.0;
  double standstill_seconds = 2.0;
  int max_tracks = 60;
  SimulationOptions simulation;
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

}  // namespace ch5
