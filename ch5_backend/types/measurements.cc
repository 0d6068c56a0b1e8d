#include "ch5_backend/types/measurements.h"

#include <algorithm>

#include "ch5_backend/math/option_checks.h"

namespace ch5 {

void ImuNoise::Validate() const {
  CheckPositive("ImuNoise::accelerometer", accelerometer);
  CheckPositive("ImuNoise::gyroscope", gyroscope);
  CheckPositive("ImuNoise::accelerometer_walk", accelerometer_walk);
  CheckPositive("ImuNoise::gyroscope_walk", gyroscope_walk);
}

std::vector<ImuSample> SamplesBetween(const std::vector<ImuMeasurement>& imu, double t0, double t1) {
  if (!(t0 < t1) || imu.empty() || t0 < imu.front().t || t1 > imu.back().t) return {};
  const auto after = [&](double time) {
    return std::lower_bound(imu.begin(), imu.end(), time,
                            [](const ImuMeasurement& measurement, double t) { return measurement.t < t; });
  };
  auto next = after(t0);
  std::vector<ImuSample> samples;
  samples.reserve(static_cast<size_t>(after(t1) - next) + 3);  // the ends, and one that a caller may add
  double last = t0;
  const auto add = [&](double t, const Vec3& acceleration, const Vec3& gyroscope) {
    samples.push_back({t - last, acceleration, gyroscope});
    last = t;
  };
  const auto add_interpolated = [&](double t, auto after) {
    if (after->t == t) return add(t, after->acceleration, after->gyroscope);
    const auto before = std::prev(after);
    const double weight = (t - before->t) / (after->t - before->t);
    add(t, before->acceleration + weight * (after->acceleration - before->acceleration),
        before->gyroscope + weight * (after->gyroscope - before->gyroscope));
  };
  add_interpolated(t0, next);
  if (next->t == t0) ++next;
  for (; next->t < t1; ++next) add(next->t, next->acceleration, next->gyroscope);
  add_interpolated(t1, next);
  return samples;
}

}  // namespace ch5
