#include "ch5_backend/window/start/standstill.h"

#include <cmath>
#include <map>

#include "ch5_backend/math/median.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/math/so3.h"

namespace ch5 {

void StandstillOptions::Validate() const {
  CheckPositive("StandstillOptions::seconds", seconds);
  CheckOption("StandstillOptions::pixels", pixels, 0);
  CheckOption("StandstillOptions::acceleration", acceleration, 0);
}

void StandstillDetector::AddImu(const ImuMeasurement& measurement) {
  constexpr double kWithoutImage = 60.0;  // what is older cannot be asked for any more [s]
  imu_.push_back(measurement);
  while (imu_.front().t < measurement.t - options_.seconds - kWithoutImage) imu_.pop_front();
}

std::optional<StandstillState> StandstillDetector::AddFrame(const Image& frame) {
  images_.push_back(frame);
  while (images_.size() > 1 && images_[1].t <= frame.t - options_.seconds) images_.pop_front();
  while (!imu_.empty() && imu_.front().t < images_.front().t) imu_.pop_front();
  if (images_.front().t > frame.t - options_.seconds || imu_.empty()) return std::nullopt;

  const std::optional<double> motion = MedianMotion(images_.front(), frame);
  if (!motion || *motion * focal_length_ > options_.pixels) return std::nullopt;
  StandstillState state;
  Vec3 force = Vec3::Zero();
  for (const ImuMeasurement& measurement : imu_) {
    force += measurement.acceleration / static_cast<double>(imu_.size());
    state.b_g += measurement.gyroscope / static_cast<double>(imu_.size());
  }
  if (std::abs(force.norm() - gravity_) > options_.acceleration) return std::nullopt;
  state.q_W_B = RotationBetween(force, Vec3::UnitZ());
  state.b_a = force - gravity_ * force.normalized();
  return state;
}

void StandstillDetector::Reset() {
  imu_.clear();
  images_.clear();
}

std::optional<double> MedianMotion(const Image& a, const Image& b) {
  std::map<int, Vec2> points;
  for (const TrackedPoint& point : a.tracks) points[point.id] = point.x;
  std::vector<double> distances;
  for (const TrackedPoint& point : b.tracks) {
    const auto it = points.find(point.id);
    if (it != points.end()) distances.push_back((point.x - it->second).norm());
  }
  if (distances.size() < 5) return std::nullopt;
  return Median(distances);
}

}  // namespace ch5
