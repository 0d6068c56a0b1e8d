#pragma once
/// Position and yaw of a window, which no measurement tells, and what it knows of its frames once these are held.

#include <memory>

#include "ch5_backend/window/window.h"

namespace ch5 {

/// Holds position and yaw of a frame where they are, each direction with this information; pitch and roll stay free,
/// as gravity tells them.
std::shared_ptr<Edge> HoldGauge(const std::shared_ptr<VertexPose>& pose, double information);

/// Covariance of a frame's [δp, δθ] (right perturbation) as the window's last graph has it at the present states. Where
/// neither the prior nor a gauge tells position and yaw, the oldest frame's are held: the frame is then known relative
/// to that one.
Mat66 PoseCovariance(const Window& window, const WindowFrame& frame);

}  // namespace ch5
