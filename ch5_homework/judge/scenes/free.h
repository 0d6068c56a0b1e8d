#pragma once
/// States without a gauge, for stage 4.

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {

/// A few frames that see points and an inverse depth; with an IMU between them if the group is the visual-inertial one.
/// The states are not those of a minimum, and need not be: H U = 0 holds everywhere. `vertices` is in the order of H's rows.
struct FreeGraph : GraphScene {
  FreeGraph(GaugeGroup group, int frames, int points, int seed)
      : GraphScene("free graph", {static_cast<int>(group), frames, points, seed}) {}
};

}  // namespace ch5::homework
