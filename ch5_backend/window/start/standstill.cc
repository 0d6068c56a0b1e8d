#include "ch5_backend/window/start/standstill.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ch5_backend/math/array_memory.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/math/so3.h"

namespace ch5 {

void StandstillOptions::Validate() const {
  CheckPositive("StandstillOptions::seconds", seconds);
  CheckOption("StandstillOptions::pixels", pixels, 0);
  CheckOption("StandstillOptions::acceleration", acceleration, 0);
  CheckOption("StandstillOptions::change", change, 0);
}

void StandstillDetector::AddImu(const ImuMeasurement& measurement) {
  constexpr double kWithoutImage = 60.0;  // what is older cannot be asked for any more [s]
  imu_.push_back(measurement);
  while (imu_.front().t < measurement.t - options_.seconds - kWithoutImage) imu_.pop_front();
}

std::optional<StandstillState> StandstillDetector::AddFrame(const Image& frame, double time_offset) {
  images_.push_back(frame);
  while (images_.size() > 1 && images_[1].t <= frame.t - options_.seconds) images_.pop_front();
  while (!imu_.empty() && imu_.front().t < images_.front().t + time_offset) imu_.pop_front();
  if (images_.front().t > frame.t - options_.seconds || imu_.size() < 2) return std::nullopt;

  const std::optional<double> motion = TypicalMotion(images_.front(), frame);
  // A slow start crosses the limit again and again.
  if (!motion || *motion * focal_length_ > 2.0 * options_.pixels) first_force_.reset();
  if (!motion || *motion * focal_length_ > options_.pixels) return std::nullopt;
  const size_t n = imu_.size();
  StandstillState state;
  Vec3 force = Vec3::Zero(), first_half = Vec3::Zero();  // parts of the mean
  for (size_t k = 0; k < n; ++k) {
    if (k == n / 2) first_half = force;
    force += imu_[k].acceleration / static_cast<double>(n);
    state.b_g += imu_[k].gyroscope / static_cast<double>(n);
  }
  if (HasForceChanged(force, first_half)) return std::nullopt;
  if (std::abs(force.norm() - gravity_) > options_.acceleration) return std::nullopt;
  state.q_W_B = RotationBetween(force, Vec3::UnitZ());
  state.b_a = force - gravity_ * force.normalized();
  return state;
}

// Images alone would take a car for resting until it has gone some decimeters, at up to a meter a second.
bool StandstillDetector::HasForceChanged(const Vec3& mean, const Vec3& first_half) {
  const auto n = static_cast<double>(imu_.size()), n_first = std::floor(0.5 * n);
  if (!first_force_) first_force_ = n / n_first * first_half;
  const Vec3 second = n / (n - n_first) * (mean - first_half);
  double variance = 0.0;
  for (const ImuMeasurement& m : imu_) variance += (m.acceleration - mean).squaredNorm() / n;
  const double noise = std::sqrt(4.0 * variance / n);  // σ of the difference of two halves' means
  return (second - *first_force_).norm() > options_.change + noise;
}

std::optional<double> TypicalMotion(const Image& a, const Image& b) {
  constexpr double kShare = 0.4;
  Array<const TrackedPoint*> points;  // by id
  points.reserve(a.tracks.size());
  for (const TrackedPoint& point : a.tracks) points.push_back(&point);
  const auto precedes = [](const TrackedPoint* one, const TrackedPoint* other) { return one->id < other->id; };
  std::sort(points.begin(), points.end(), precedes);
  Array<double> distances;
  distances.reserve(points.size());
  for (const TrackedPoint& point : b.tracks) {
    const auto it = std::lower_bound(points.begin(), points.end(), &point, precedes);
    if (it != points.end() && (*it)->id == point.id) distances.push_back((point.x - (*it)->x).norm());
  }
  if (distances.size() < 5) return std::nullopt;
  return Quantile(std::move(distances), kShare);
}

}  // namespace ch5
