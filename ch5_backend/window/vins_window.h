#pragma once
/// How VINS-Mono's window slides. Its functions are homework stage 6 (solutions/vins_window.cc).
///
///   kOld         the second newest frame is a keyframe: the oldest frame is marginalized into the prior
///   kSecondNew   it is not: that frame leaves, its observations are lost, its IMU samples go to the newest frame
///
///   0  1  2  …  n−2  n−1  n                0  1  2  …  n−2  n−1  n
///   ×                                                        ×
///
/// Source: Qin, Li, Shen, "VINS-Mono", TRO 2018, §VI-D.

#include "ch5_backend/window/failure.h"
#include "ch5_backend/window/window.h"

namespace ch5 {

/// Which frame leaves: the oldest, or the second newest.
enum class MarginalizationFlag { kOld, kSecondNew };

/// What a marginalization takes: these edges, and those of their vertices that are dropped.
struct DropSet {
  std::vector<std::shared_ptr<Edge>> edges;
  std::vector<std::shared_ptr<Vertex>> vertices;
};

/// MARGIN_OLD: drops the oldest frame's pose, its speed and biases, and the inverse depths hosted there, with every
/// edge of window.graph at one of them: the old prior, the IMU between frames 0 and 1, those landmarks' observations.
DropSet DropSetOfMarginOld(const Window& window);

/// MARGIN_SECOND_NEW: drops the pose of the second newest frame out of the prior, which is the only edge. Empty if
/// the prior does not hold that pose: then there is nothing to marginalize.
DropSet DropSetOfMarginSecondNew(const Window& window);

/// Lets the frame leave: its observations are forgotten (ForgetObservations), its states leave window.frames. When
/// the second newest leaves, the newest frame's preintegration becomes that frame's followed by its own.
void SlideWindow(MarginalizationFlag flag, Window* window);

/// Checks the newest frame after a solve: ‖b_a‖ > 2.5 m/s², ‖b_g‖ > 1 rad/s, a step of more than 5 m, or of more
/// than 1 m in height. Lost tracks and fast turns are no failure.
/// @param last_p  position of the newest frame after the previous solve [m]
Failure DetectFailure(const Window& window, const Vec3& last_p);

}  // namespace ch5
