#include "ch5_backend/window/start/sensor_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

namespace ch5 {
namespace {

// Before that, nothing is said.
constexpr double kLeastSeconds = 0.5;
constexpr int kLeastMeasurements = 20, kLeastImages = 5;

template <typename... Values>
std::string Sentence(const char* format, Values... values) {
  char text[240];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

}  // namespace

void SensorCheck::AddImu(const ImuMeasurement& measurement) {
  if (measurements_ > 0) seconds_ += measurement.t - last_.t;
  force_ += measurement.acceleration.norm();
  rate_ += measurement.gyroscope.norm();
  fastest_ = std::max(fastest_, measurement.gyroscope.norm());
  if (measurements_ > 1) {
    force_scatter_ += (before_last_.acceleration - 2.0 * last_.acceleration + measurement.acceleration).squaredNorm();
  }
  ++measurements_;
  before_last_ = last_;
  last_ = measurement;
}

void SensorCheck::AddFrame(const Image& image) {
  std::set<int> before;
  for (const TrackedPoint& point : last_image_.tracks) before.insert(point.id);
  for (const TrackedPoint& point : image.tracks) tracked_ += static_cast<int>(before.count(point.id));
  last_image_ = image;
  ++images_;
}

// At rest ‖a‖ is gravity's; in motion its mean is not far from that.
std::string SensorCheck::SuspectForce(double gravity) const {
  constexpr double kNear = 0.3;          // of gravity
  constexpr double kFastestTurn = 10.0;  // of a hand or a camera on a vehicle [rad/s]
  const double force = force_ / measurements_, rate = rate_ / measurements_;
  const bool is_gravity = std::abs(force - gravity) < 0.5 * gravity;
  if (!is_gravity && std::abs(rate - gravity) < kNear * gravity) {
    return Sentence("the gyroscope's mean is %.3g and the accelerometer's %.3g: are their columns swapped?", rate,
                    force);
  }
  if (std::abs(force - 1.0) < kNear && !is_gravity) {
    return Sentence("the mean specific force is %.3g m/s², where gravity is %.3g: is it in units of g?", force,
                    gravity);
  }
  if (!is_gravity) {
    return Sentence("the mean specific force is %.3g m/s², where gravity is %.3g: check units and columns", force,
                    gravity);
  }
  if (fastest_ > kFastestTurn) {
    return Sentence("the gyroscope has reached %.3g rad/s: is it in degrees?", fastest_);
  }
  return "";
}

// A second difference of noise has six times its variance, on each of three axes; of motion it has next to nothing.
std::string SensorCheck::SuspectNoise(const ImuNoise& noise) const {
  constexpr double kTimes = 5.0;
  const double sigma = std::sqrt(force_scatter_ / (18.0 * (measurements_ - 2)));
  if (noise.continuous || sigma < kTimes * noise.accelerometer) return "";
  return Sentence(
      "the accelerometer scatters by %.2g m/s², but ImuNoise::accelerometer = %.2g is taken for that of one "
      "measurement: if it is a density, set ImuNoise::continuous",
      sigma, noise.accelerometer);
}

std::string SensorCheck::Suspicion(double gravity, const ImuNoise& noise) const {
  if (images_ >= kLeastImages && !last_image_.tracks.empty() && tracked_ == 0) {
    return "no point of an image has the id of one in the image before: are they tracks?";
  }
  if (seconds_ < kLeastSeconds || measurements_ < kLeastMeasurements) return "";
  const std::string force = SuspectForce(gravity);
  return force.empty() ? SuspectNoise(noise) : force;
}

}  // namespace ch5
