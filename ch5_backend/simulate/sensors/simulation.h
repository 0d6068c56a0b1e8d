#pragma once
/// A simulated recording, of the same form as a real one.

#include "ch5_backend/simulate/sensors/camera_simulator.h"
#include "ch5_backend/simulate/sensors/imu_simulator.h"
#include "ch5_backend/simulate/sensors/paths.h"

namespace ch5 {

/// A camera that looks along B's x axis, its image upright when B's z axis points up, 6–7 cm from the IMU.
Calibration ForwardCamera();

/// The same with a second camera like it, 11 cm to the right.
Calibration ForwardStereo();

struct SimulationOptions {
  Calibration calibration = ForwardCamera();
  ImuOptions imu;
  CameraOptions camera;
};

/// IMU, images and ground truth (at the IMU's rate) along `trajectory` among the landmarks `points_W`.
/// @throws OptionError as SimulateImu and SimulateCamera do
Recording SimulateRecording(const Trajectory& trajectory, const std::vector<Vec3>& points_W,
                            const SimulationOptions& options = {});

/// A hand-held camera in a room of 10 m × 10 m × 5 m with so many landmarks on its walls, drawn with `seed`.
/// @throws OptionError as Handheld and SimulateRecording do
Recording SimulateInRoom(const HandheldOptions& path, int landmarks, const SimulationOptions& options = {},
                         uint64_t seed = 1);

}  // namespace ch5
