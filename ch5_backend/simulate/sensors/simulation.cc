#include "ch5_backend/simulate/sensors/simulation.h"

#include "ch5_backend/simulate/sensors/scene_points.h"

namespace ch5 {

// Columns of R_B_C: the image's right is −y of B, its down is −z, its depth is +x.
Calibration ForwardCamera() {
  Calibration calibration;
  calibration.T_B_C = {Qd(0.5, -0.5, 0.5, -0.5), Vec3(0.05, 0.04, 0.03)};
  return calibration;
}

Calibration ForwardStereo() {
  Calibration calibration = ForwardCamera();
  calibration.camera1 = calibration;
  calibration.camera1->T_B_C.p.y() -= 0.11;
  return calibration;
}

Recording SimulateRecording(const Trajectory& trajectory, const std::vector<Vec3>& points_W,
                            const SimulationOptions& options) {
  SimulatedImu imu = SimulateImu(trajectory, options.calibration, options.imu);
  Recording recording;
  recording.calibration = options.calibration;
  recording.imu = std::move(imu.measurements);
  recording.truth = std::move(imu.truth);
  recording.images = SimulateCamera(trajectory, points_W, options.calibration, options.camera);
  return recording;
}

Recording SimulateInRoom(const HandheldOptions& path, int landmarks, const SimulationOptions& options, uint64_t seed) {
  Random random(seed);
  const std::vector<PlanePatch> walls = RoomWalls(Vec3(-5, -5, -2), Vec3(5, 5, 3));
  return SimulateRecording(Handheld(path), PointsOnPlanes(walls, landmarks, &random), options);
}

}  // namespace ch5
