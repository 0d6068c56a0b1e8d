#include "ch5_backend/simulate/sensors/scene_points.h"

#include <numeric>

namespace ch5 {
namespace {

// The patch under a random point of the whole area.
const PlanePatch& Choose(const std::vector<PlanePatch>& patches, const std::vector<double>& areas, Random* random) {
  double left = random->Uniform() * std::accumulate(areas.begin(), areas.end(), 0.0);
  size_t i = 0;
  while (i + 1 < patches.size() && left >= areas[i]) left -= areas[i++];
  return patches[i];
}

}  // namespace

std::vector<Vec3> PointsOnPlanes(const std::vector<PlanePatch>& patches, int count, Random* random) {
  std::vector<Vec3> points;
  if (patches.empty()) return points;
  std::vector<double> areas;
  for (const PlanePatch& patch : patches) areas.push_back(patch.side_a.cross(patch.side_b).norm());
  for (int k = 0; k < count; ++k) {
    const PlanePatch& patch = Choose(patches, areas, random);
    const double s = random->Uniform();
    const double t = random->Uniform();
    points.push_back(patch.corner + s * patch.side_a + t * patch.side_b);
  }
  return points;
}

std::vector<PlanePatch> RoomWalls(const Vec3& low, const Vec3& high) {
  const Vec3 size = high - low;
  const Vec3 x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  return {{low, x, y}, {low, y, z}, {low, z, x}, {high, -x, -y}, {high, -y, -z}, {high, -z, -x}};
}

std::vector<PlanePatch> GaugePaperPlanes() {
  return {{Vec3(-3, 4, -3), Vec3(4, 1, 0), Vec3(0, 0, 6)},
          {Vec3(1, 6, -3), Vec3(4, -3, 0), Vec3(0, 0, 6)},
          {Vec3(-4, 3, -3), Vec3(10, 0, 0), Vec3(0, 3, 0)}};
}

std::vector<Vec3> PointsAlongPath(const Trajectory& trajectory, const Calibration& calibration, double near, double far,
                                  int count, Random* random) {
  std::vector<Vec3> points;
  for (int k = 0; k < count; ++k) {
    const Transform T_W_B = trajectory.At(random->Uniform(0.0, trajectory.Duration())).T_W_B;
    const double u = random->Uniform(0.0, calibration.width);
    const double v = random->Uniform(0.0, calibration.height);
    const double depth = random->Uniform(near, far);
    const Vec3 p_C = depth * calibration.Normalized({u, v}).homogeneous();
    points.push_back(T_W_B.q * (calibration.T_B_C.q * p_C + calibration.T_B_C.p) + T_W_B.p);
  }
  return points;
}

}  // namespace ch5
