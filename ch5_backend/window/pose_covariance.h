#pragma once
/// The uncertainty of the pose of one frame of a window.

#include "ch5_backend/window/window.h"

namespace ch5 {

/// Covariance of a frame's [δp, δθ] (right perturbation) from the window's last graph at the present states. Where
/// neither the prior nor a gauge prior fixes position and yaw, they are held at the oldest frame: the covariance is then
/// that of the pose relative to the oldest frame.
Mat66 PoseCovariance(const Window& window, const Frame& frame);

}  // namespace ch5
