#pragma once
/// The paths flown in this chapter: the gauge paper's three, and a random one.

#include <cstdint>

#include "ch5_backend/simulate/sensors/trajectory.h"

namespace ch5 {

/// The three paths of Zhang, Gallego, Scaramuzza, "On the Comparison of Gauge Freedom Handling", RA-L 2018.
enum class GaugePath { kSine, kArc, kRectangle };

/// 5 m in 2.5 s, a mean speed of 2 m/s as in the paper, whose shapes are known from a figure only: a sine, an arc of
/// 120° and a rectangle with rounded corners. B's x axis looks along +y of W, toward the scene, and sways a little; on
/// the arc it keeps looking at the arc's center.
Trajectory GaugePaperPath(GaugePath path);

struct HandheldOptions {
  double duration = 30.0;           ///< [s]
  double standstill_seconds = 0.0;  ///< exactly at rest for this time, then a smooth start [s]
  double knot_spacing = 0.8;        ///< time between control points: shorter is livelier [s]
  double position_sigma = 0.9;      ///< spread of the control points' position about the origin, per axis [m]
  double yaw_step = 0.5;            ///< step of the yaw's random walk between control points, σ [rad]
  double tilt_sigma = 0.25;         ///< spread of pitch and roll [rad]
  uint64_t seed = 1;
};

/// A smooth random motion as of a hand or a small drone: quintic B-splines through seeded control points. Heights are
/// halved. With the defaults: on average about 1 m/s and 2 m/s², within 2.5 m of the origin.
/// @throws OptionError if a time is not positive, or a spread negative
Trajectory Handheld(const HandheldOptions& options);

}  // namespace ch5
