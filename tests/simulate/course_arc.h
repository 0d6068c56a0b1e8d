#pragma once
/// A path whose every derivative is known.

#include "ch5_backend/simulate/sensors/trajectory.h"

namespace ch5 {

/// The course's quarter circle of radius 8 m (see mono_ba.h) flown in `duration` seconds:
///   θ = ½π t/duration,   p = (8 cos θ − 8, 8 sin θ, sin 2θ),   yaw = θ
inline Trajectory CourseArc(double duration) {
  const auto formula = [duration](const Jet& t) {
    const Jet theta = (0.5 * M_PI / duration) * t;
    return Coordinates{{8.0 * Cos(theta) - 8.0, 8.0 * Sin(theta), Sin(2.0 * theta)}, theta, 0.0, 0.0};
  };
  return Trajectory(formula, duration);
}

}  // namespace ch5
