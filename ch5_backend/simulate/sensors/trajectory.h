#pragma once
/// Motions known exactly at every time: the ground truth of all simulations.
///
/// A trajectory is a formula for six functions of time; velocity, acceleration and rate are derived from it without
/// approximation.  In the spirit of gtsam's Scenario.

#include <array>
#include <functional>

#include "ch5_backend/math/so3.h"
#include "ch5_backend/simulate/sensors/jet.h"

namespace ch5 {

/// The state of a moving body B in the world W at one time.
struct Motion {
  Transform T_W_B;
  Vec3 v_W = Vec3::Zero();      ///< velocity of B in W [m/s]
  Vec3 a_W = Vec3::Zero();      ///< acceleration of B in W [m/s²]; at rest it is 0, gravity is not in it
  Vec3 omega_B = Vec3::Zero();  ///< angular rate of B against W, seen from B [rad/s]
};

/// Position [m] and angles [rad] of R_W_B = R_z(yaw) R_y(pitch) R_x(roll), as functions of time.
struct Coordinates {
  std::array<Jet, 3> position;
  Jet yaw, pitch, roll;
};

class Trajectory {
 public:
  using Formula = std::function<Coordinates(const Jet& time)>;

  /// @param duration  in s; the motion is meant for times in [0, duration] and defined a little beyond
  Trajectory(Formula formula, double duration) : formula_(std::move(formula)), duration_(duration) {}

  /// The motion at time `t` [s].
  Motion At(double t) const;
  double Duration() const { return duration_; }

 private:
  Formula formula_;
  double duration_;
};

/// Length of the path from time 0 to the end [m], by Simpson's rule on 2,000 intervals.
double PathLength(const Trajectory& trajectory);

}  // namespace ch5
