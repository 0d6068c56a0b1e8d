#pragma once
/// Landmarks to look at: on planes, in a box, or along a trajectory.

#include <vector>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/simulate/sensors/trajectory.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

/// The parallelogram  corner + s·side_a + t·side_b,  s, t ∈ [0, 1).
struct PlanePatch {
  Vec3 corner, side_a, side_b;  ///< in W [m]
};

/// `count` points spread evenly over the patches' whole area, at random.
std::vector<Vec3> PointsOnPlanes(const std::vector<PlanePatch>& patches, int count, Random* random);

/// The six faces of a box: a room with bare walls.
std::vector<PlanePatch> RoomWalls(const Vec3& low, const Vec3& high);

/// Three patches at different depths and slants in front of GaugePaperPath's camera, 3–6 m toward +y.
std::vector<PlanePatch> GaugePaperPlanes();

/// `count` points, each in the image at a random time, at a depth between `near` and `far` [m].
std::vector<Vec3> PointsAlongPath(const Trajectory& trajectory, const Calibration& calibration, double near, double far,
                                  int count, Random* random);

}  // namespace ch5
