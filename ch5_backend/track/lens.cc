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

}  // namespace

Vec2 Lens::Distort(const Vec2& x) const {
  if (model == Model::kRadialTangential) return Bend(k, k3, x).first;
  const double r = x.norm();
  return r == 0.0 ? x : Vec2(BendAngle(k, std::atan(r)).first / r * x);
}

std::optional<Vec2> Lens::Undistort(const Vec2& x_d) const {
  if (model == Model::kEquidistant) return UndistortEquidistant(k, x_d);
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
