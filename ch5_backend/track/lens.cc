#include "ch5_backend/track/lens.h"

#include <cmath>

#include <Eigen/LU>

namespace ch5 {
namespace {

constexpr int kSteps = 30;
constexpr double kAccuracy = 1e-9;
constexpr double kLargestAngle = 80.0 * M_PI / 180.0;

// θ_d(θ) and its derivative.
std::pair<double, double> BendAngle(const Eigen::Vector4d& k, double angle) {
  const double s = angle * angle;
  const double factor = 1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])));
  const double slope = 1.0 + s * (3.0 * k[0] + s * (5.0 * k[1] + s * (7.0 * k[2] + s * 9.0 * k[3])));
  return {angle * factor, slope};
}

// x_d(x) and dx_d/dx.
std::pair<Vec2, Mat22> Bend(const Eigen::Vector4d& k, double k3, const Vec2& x) {
  const double n = x.squaredNorm(), radial = 1.0 + n * (k[0] + n * (k[1] + n * k3));
  const double p1 = k[2], p2 = k[3], xy = x.x() * x.y();
  const Vec2 x_d =
      radial * x + Vec2(2.0 * p1 * xy + p2 * (n + 2.0 * x.x() * x.x()), p1 * (n + 2.0 * x.y() * x.y()) + 2.0 * p2 * xy);
  Mat22 J = radial * Mat22::Identity() + 2.0 * (k[0] + n * (2.0 * k[1] + n * 3.0 * k3)) * x * x.transpose();
  const double off_diagonal = 2.0 * (p1 * x.x() + p2 * x.y());
  J(0, 0) += 2.0 * p1 * x.y() + 6.0 * p2 * x.x();
  J(1, 1) += 6.0 * p1 * x.y() + 2.0 * p2 * x.x();
  J(0, 1) += off_diagonal;
  J(1, 0) += off_diagonal;
  return {x_d, J};
}

std::optional<Vec2> UndistortEquidistant(const Eigen::Vector4d& k, const Vec2& x_d) {
  const double bent = x_d.norm();
  double angle = std::min(bent, kLargestAngle);
  for (int step = 0; step < kSteps; ++step) {
    const auto [value, slope] = BendAngle(k, angle);
    if (slope <= 0.0) return std::nullopt;  // the model turns back here
    if (std::abs(value - bent) < kAccuracy) {
      if (angle > kLargestAngle) return std::nullopt;
      return bent == 0.0 ? x_d : Vec2(std::tan(angle) / bent * x_d);
    }
    angle -= (value - bent) / slope;
  }
  return std::nullopt;
}

// Usenko 2018, eqs. 46 to 52, with n = ‖x_d / (1 + ξ)‖².
std::optional<Vec2> UndistortDoubleSphere(double xi, double alpha, const Vec2& x_d) {
  const Vec2 m = x_d / (1.0 + xi);
  const double n = m.squaredNorm(), inside = 1.0 - (2.0 * alpha - 1.0) * n;
  if (inside < 0.0) return std::nullopt;
  const double m_z = (1.0 - alpha * alpha * n) / (alpha * std::sqrt(inside) + 1.0 - alpha);
  const double under_root = m_z * m_z + (1.0 - xi * xi) * n;
  if (under_root < 0.0) return std::nullopt;
  const double factor = (m_z * xi + std::sqrt(under_root)) / (m_z * m_z + n);
  const double z = factor * m_z - xi;  // of a ray of length 1
  return z < std::cos(kLargestAngle) ? std::nullopt : std::optional<Vec2>(factor / z * m);
}

double DoubleSphere(double xi, double alpha, double n) {
  const double d1 = std::sqrt(n + 1.0), z = xi * d1 + 1.0;
  return (1.0 + xi) / (alpha * std::sqrt(n + z * z) + (1.0 - alpha) * z);
}

}  // namespace

Vec2 Lens::Distort(const Vec2& x) const {
  if (model == Model::kRadialTangential) return Bend(k, k3, x).first;
  if (model == Model::kDoubleSphere) return DoubleSphere(k[0], k[1], x.squaredNorm()) * x;
  const double r = x.norm(), slope = 2.0 * std::tan(k[0] / 2.0);  // slope of the field of view alone
  if (r == 0.0) return x;
  return (model == Model::kFieldOfView ? std::atan(slope * r) / slope : BendAngle(k, std::atan(r)).first) / r * x;
}

std::optional<Vec2> Lens::Undistort(const Vec2& x_d) const {
  if (model == Model::kEquidistant) return UndistortEquidistant(k, x_d);
  if (model == Model::kDoubleSphere) return UndistortDoubleSphere(k[0], k[1], x_d);
  if (model == Model::kFieldOfView) {
    const double r_d = x_d.norm(), slope = 2.0 * std::tan(k[0] / 2.0), angle = slope * r_d;
    const double r = angle < M_PI_2 ? std::tan(angle) / slope : HUGE_VAL;
    if (std::atan(r) > kLargestAngle) return std::nullopt;
    return r_d == 0.0 ? x_d : Vec2(r / r_d * x_d);
  }
  Vec2 x = x_d;
  for (int step = 0; step < kSteps; ++step) {
    const auto [bent, J] = Bend(k, k3, x);
    if (J.determinant() <= 0.0) return std::nullopt;  // likewise
    if ((bent - x_d).norm() < kAccuracy) {
      return std::atan(x.norm()) > kLargestAngle ? std::nullopt : std::optional(x);
    }
    x -= J.inverse() * (bent - x_d);
  }
  return std::nullopt;
}

}  // namespace ch5
