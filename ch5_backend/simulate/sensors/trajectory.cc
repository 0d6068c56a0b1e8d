#include "ch5_backend/simulate/sensors/trajectory.h"

namespace ch5 {
namespace {

// ω_B of R = R_z(ψ) R_y(θ) R_x(φ):  [φ̇ − ψ̇ sin θ,  θ̇ cos φ + ψ̇ sin φ cos θ,  −θ̇ sin φ + ψ̇ cos φ cos θ]
// Source: Diebel, "Representing Attitude", 2006, §5.6.
Vec3 BodyRate(const Coordinates& x) {
  const double sin_pitch = std::sin(x.pitch.value), cos_pitch = std::cos(x.pitch.value);
  const double sin_roll = std::sin(x.roll.value), cos_roll = std::cos(x.roll.value);
  return {x.roll.rate - x.yaw.rate * sin_pitch, x.pitch.rate * cos_roll + x.yaw.rate * sin_roll * cos_pitch,
          -x.pitch.rate * sin_roll + x.yaw.rate * cos_roll * cos_pitch};
}

Qd Attitude(const Coordinates& x) {
  return ExpSO3(Vec3(0, 0, x.yaw.value)) * ExpSO3(Vec3(0, x.pitch.value, 0)) * ExpSO3(Vec3(x.roll.value, 0, 0));
}

Vec3 Parts(const std::array<Jet, 3>& x, double Jet::*part) { return {x[0].*part, x[1].*part, x[2].*part}; }

}  // namespace

Motion Trajectory::At(double t) const {
  const Coordinates x = formula_(Jet::Time(t));
  Motion motion;
  motion.T_W_B = {Attitude(x), Parts(x.position, &Jet::value)};
  motion.v_W = Parts(x.position, &Jet::rate);
  motion.a_W = Parts(x.position, &Jet::second);
  motion.omega_B = BodyRate(x);
  return motion;
}

double PathLength(const Trajectory& trajectory) {
  constexpr int kIntervals = 2000;
  const double h = trajectory.Duration() / kIntervals;
  double sum = 0.0;
  for (int k = 0; k <= kIntervals; ++k) {
    const double weight = k == 0 || k == kIntervals ? 1.0 : (k % 2 == 1 ? 4.0 : 2.0);
    sum += weight * trajectory.At(k * h).v_W.norm();
  }
  return sum * h / 3.0;
}

}  // namespace ch5
