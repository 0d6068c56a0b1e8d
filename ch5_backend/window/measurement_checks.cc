#include "ch5_backend/window/measurement_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "ch5_backend/math/array_memory.h"

namespace ch5 {
namespace {

std::string At(double t) { return " at t = " + std::to_string(t) + " s"; }

std::string RepeatsOrPrecedes(double t, double last) {
  return (t == last ? " repeats the one" : " is before the one") + At(last);
}

}  // namespace

void CheckMeasurement(const ImuMeasurement& measurement, const std::vector<ImuMeasurement>& earlier) {
  if (!std::isfinite(measurement.t) || !measurement.acceleration.allFinite() || !measurement.gyroscope.allFinite()) {
    throw MeasurementError("the IMU measurement" + At(measurement.t) + " holds a number that is not finite");
  }
  constexpr double kMost = 1e4;  // m/s² and rad/s: no sensor's
  if (measurement.acceleration.norm() > kMost || measurement.gyroscope.norm() > kMost) {
    throw MeasurementError("the IMU measurement" + At(measurement.t) + " is larger than 1e4 m/s² or rad/s");
  }
  if (!earlier.empty() && measurement.t <= earlier.back().t) {
    throw MeasurementError("the IMU measurement" + At(measurement.t) +
                           RepeatsOrPrecedes(measurement.t, earlier.back().t));
  }
}

namespace {

// @param image  " of the image at t = …", or of camera 1's
void CheckTracks(const std::vector<TrackedPoint>& tracks, const char* image, double t) {
  constexpr double kFar = 10.0;  // 84° off the axis
  constexpr double kMost = 1e3;  // 89.9°: no lens's, and the square of 1e160 is not finite
  size_t far = 0;
  const TrackedPoint* beyond = nullptr;
  Array<int> ids;
  ids.reserve(tracks.size());
  for (const TrackedPoint& point : tracks) {
    if (!point.x.allFinite())
      throw MeasurementError("track " + std::to_string(point.id) + " of " + image + At(t) + " is not finite");
    ids.push_back(point.id);
    if (point.x.norm() > kFar) ++far;
    if (point.x.norm() > kMost) beyond = &point;
  }
  std::ostringstream text;
  if (2 * far > tracks.size()) {
    text << "most tracks of " << image << At(t) << " are far from the normalized plane's center, one at ("
         << tracks.front().x.transpose() << "): are they pixels?";
    throw MeasurementError(text.str());
  }
  if (beyond) {
    text << "track " << beyond->id << " of " << image << At(t) << " is at (" << beyond->x.transpose()
         << ") of the normalized plane, where no lens sees";
    throw MeasurementError(text.str());
  }
  std::sort(ids.begin(), ids.end());
  const auto repeated = std::adjacent_find(ids.begin(), ids.end());
  if (repeated != ids.end()) {
    throw MeasurementError("track " + std::to_string(*repeated) + " stands twice in " + image + At(t));
  }
}

}  // namespace

void CheckImage(const Image& image, double last_time) {
  if (!std::isfinite(image.t)) throw MeasurementError("the image's time is not finite");
  if (image.t <= last_time) {
    throw MeasurementError("the image" + At(image.t) + RepeatsOrPrecedes(image.t, last_time));
  }
  CheckTracks(image.tracks, "the image", image.t);
  CheckTracks(image.tracks1, "camera 1's image", image.t);
}

double LongestImuGap(const std::vector<ImuMeasurement>& imu, double t0, double t1) {
  if (imu.empty()) return std::numeric_limits<double>::infinity();
  double last = std::min(t0, imu.front().t), longest = 0.0;
  for (auto measurement = imu.begin(); measurement != imu.end() && last < t1; ++measurement) {
    longest = std::max(longest, measurement->t - last);
    last = measurement->t;
  }
  return std::max(longest, t1 - last);
}

}  // namespace ch5
