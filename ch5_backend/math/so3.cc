#include "ch5_backend/math/so3.h"

#include <cmath>

namespace ch5 {
namespace {

// Below this angle the series below are exact to the last bits, and the closed forms begin to cancel.
constexpr double kSeriesAngle = 0.2;

// (1 − cos θ)/θ² in the form ½ sinc²(θ/2), which never cancels.
double OneMinusCosOverSquare(double angle) {
  if (angle < 1e-8) return 0.5;
  const double s = std::sin(0.5 * angle) / angle;
  return 2.0 * s * s;
}

// (θ − sin θ)/θ³ = 1/3! − θ²/5! + θ⁴/7! − …
double AngleMinusSinOverCube(double angle) {
  if (angle > kSeriesAngle) return (angle - std::sin(angle)) / (angle * angle * angle);
  const double t = angle * angle;
  return (1.0 - t / 20.0 * (1.0 - t / 42.0 * (1.0 - t / 72.0 * (1.0 - t / 110.0)))) / 6.0;
}

// 1/θ² − cot(θ/2)/(2θ) = 1/12 + θ²/720 + θ⁴/30240 + θ⁶/1209600 + θ⁸/47900160 + …
double InverseJacobianCoefficient(double angle) {
  const double t = angle * angle;
  if (angle > kSeriesAngle) return (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / t;
  return 1.0 / 12.0 + t * (1.0 / 720.0 + t * (1.0 / 30240.0 + t * (1.0 / 1209600.0 + t / 47900160.0)));
}

}  // namespace

Qd ExpSO3(const Vec3& theta) {
  const double angle = theta.norm();
  // sin(θ/2)/θ → ½ − θ²/48; at 1e-4 the next term, θ⁴/3840, is below 1e-19.
  const double k = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  return Qd(std::cos(0.5 * angle), k * theta.x(), k * theta.y(), k * theta.z());
}

// q = [½s, â × b̂/s],  s = ‖â + b̂‖ = 2 cos ½θ, which near half a turn has digits that 1 + cos θ has lost.
Qd RotationBetween(const Vec3& a, const Vec3& b) {
  const Vec3 a_unit = a.normalized(), b_unit = b.normalized();
  const double s = (a_unit + b_unit).norm();
  if (s < 1e-8) {  // â × b̂/s has an error of ε/s: any axis across a is as good
    const Vec3 axis = a_unit.unitOrthogonal();
    return Qd(0.0, axis.x(), axis.y(), axis.z());
  }
  const Vec3 v = a_unit.cross(b_unit) / s;
  return Qd(0.5 * s, v.x(), v.y(), v.z()).normalized();
}

Vec3 LogSO3(const Qd& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;  // the shorter way round
  const double w = sign * q.w();
  const double n = q.vec().norm();
  // θ = 2 atan2(‖v‖, w);  θ/‖v‖ → 2/w − 2‖v‖²/(3w³) for small ‖v‖.
  const double k = n < 1e-4 ? 2.0 / w - 2.0 * n * n / (3.0 * w * w * w) : 2.0 * std::atan2(n, w) / n;
  return sign * k * q.vec();
}

Mat33 LeftJacobianSO3(const Vec3& theta) {
  const double angle = theta.norm();
  const Mat33 A = Hat(theta);
  return Mat33::Identity() + OneMinusCosOverSquare(angle) * A + AngleMinusSinOverCube(angle) * A * A;
}

Mat33 RightJacobianInverseSO3(const Vec3& theta) {
  const Mat33 A = Hat(theta);
  return Mat33::Identity() + 0.5 * A + InverseJacobianCoefficient(theta.norm()) * A * A;
}

}  // namespace ch5
