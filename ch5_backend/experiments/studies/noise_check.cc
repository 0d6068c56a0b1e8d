#include "ch5_backend/experiments/studies/noise_check.h"

#include <cmath>

#include "ch5_backend/math/median.h"

namespace ch5 {
namespace {

// Whether what was measured is clearly more than what was told.
bool IsMore(const MeasuredNoise& noise, double told, double times) {
  constexpr double kSure = 4.0;
  return noise.value - kSure * noise.sigma > times * told;
}

RecordingWarning Warning(const std::string& name, const std::string& of, const MeasuredNoise& noise, double told,
                         const std::string& unit, const std::string& what_to_do) {
  constexpr double kModel = 0.05;  // what the models of noise leave out
  std::ostringstream found;
  found << std::setprecision(2) << noise.value << " ± " << std::setprecision(1)
        << std::max(noise.sigma, kModel * noise.value);
  std::ostringstream words;
  words << std::setprecision(2) << "the " << of << " " << found.str() << " " << unit << ", not " << told << what_to_do;
  return {name, noise.value, told, words.str(), found.str()};
}

// Of the means of `of` readings in a row, dt apart: by differences of this order, in parts of a quarter of a second.
std::vector<double> DensitiesOfParts(const std::vector<ImuMeasurement>& imu, Vec3 ImuMeasurement::*reading, size_t of,
                                     double dt, size_t order) {
  constexpr double kSeconds = 0.25;
  std::vector<Vec3> x;
  for (size_t first = 0; first + of <= imu.size(); first += of) {
    x.push_back(Vec3::Zero());
    for (size_t k = first; k < first + of; ++k) x.back() += imu[k].*reading / static_cast<double>(of);
  }
  double gain = 1.0;  // of the variance: 2·n over n, 20 for order 3
  for (size_t n = 1; n <= order && !x.empty(); ++n) {
    for (size_t k = 0; k + 1 < x.size(); ++k) x[k] = x[k + 1] - x[k];
    x.pop_back();
    gain *= 2.0 * static_cast<double>(2 * n - 1) / static_cast<double>(n);
  }
  const double step = dt * static_cast<double>(of);
  const size_t length = std::max<size_t>(10, static_cast<size_t>(kSeconds / step));
  std::vector<double> parts;
  for (size_t first = 0; first + length <= x.size(); first += length) {
    double squares = 0.0;
    for (size_t k = first; k < first + length; ++k) squares += x[k].squaredNorm() / (3.0 * gain);
    parts.push_back(std::sqrt(squares / static_cast<double>(length) * step));
  }
  return parts;
}

}  // namespace

std::optional<SensorNoise> NoiseOfSensor(const std::vector<ImuMeasurement>& imu, Vec3 ImuMeasurement::*reading) {
  constexpr size_t kFewest = 20, kOrder = 3, kSlowOrder = 6;  // in means there is more motion
  constexpr double kTogether = 0.04;                          // [s]
  constexpr double kQuiet = 0.1, kAlike = 0.75;  // nine in ten parts of white noise have at least 0.89 of the median
  constexpr double kSure = 5.0;
  const double dt = (imu.back().t - imu.front().t) / static_cast<double>(imu.size() - 1);
  const auto measured = [](const std::vector<double>& parts) {
    const double median = Median(parts), quiet = Quantile(parts, kQuiet);
    return MeasuredNoise{median, (median - quiet) / std::sqrt(static_cast<double>(parts.size()))};
  };
  const std::vector<double> parts = DensitiesOfParts(imu, reading, 1, dt, kOrder);
  if (parts.size() < kFewest || Quantile(parts, kQuiet) < kAlike * Median(parts)) return std::nullopt;
  const auto together = std::max<size_t>(2, static_cast<size_t>(std::lround(kTogether / dt)));
  const MeasuredNoise all = measured(parts);
  const std::vector<double> slow_parts = DensitiesOfParts(imu, reading, together, dt, kSlowOrder);
  if (slow_parts.size() < kFewest / 4) return SensorNoise{all, std::nullopt};
  const MeasuredNoise slow = measured(slow_parts);
  const bool vibrates = all.value - slow.value > kSure * std::hypot(all.sigma, slow.sigma);
  return SensorNoise{vibrates ? slow : all, vibrates ? std::optional(all) : std::nullopt};
}

RecordingWarnings CheckNoise(Recording* recording, OdometrySettings* settings) {
  constexpr double kTimes = 1.5, kTimesPixels = 1.15;  // less makes no difference
  RecordingWarnings warnings;
  ImuNoise& noise = recording->calibration.noise;
  const auto check = [&](const std::string& of, const std::string& unit, Vec3 ImuMeasurement::*reading, double* told) {
    const auto found = NoiseOfSensor(recording->imu, reading);
    if (!found) return;
    if (found->with_vibration && IsMore(*found->with_vibration, *told, kTimes)) {
      warnings.push_back(Warning(of + "_vibration", of + " vibrates: as noise this would be", *found->with_vibration,
                                 *told, unit + "/√Hz",
                                 ", which is imu." + of + "_noise_density; it is not taken for noise"));
    }
    if (!IsMore(found->noise, *told, kTimes)) return;
    warnings.push_back(Warning(of + "_noise", of + "'s noise and vibration are", found->noise, *told, unit + "/√Hz",
                               ", which is imu." + of + "_noise_density; estimated with what was measured"));
    *told = found->noise.value;
  };
  check("gyroscope", "rad/s", &ImuMeasurement::gyroscope, &noise.gyroscope);
  check("accelerometer", "m/s²", &ImuMeasurement::acceleration, &noise.accelerometer);
  const double told = settings->estimator.weights.pixel_sigma;
  const auto tracks = NoiseOfTracks(*recording);
  if (tracks) settings->track_noise = tracks->value;
  if (!tracks || !IsMore(*tracks, told, kTimesPixels)) return warnings;
  const bool uses = settings->finds_noise;
  warnings.push_back(
      Warning(uses ? "track_noise" : "track_noise_set", "tracks' noise is", *tracks, told, "px",
              uses ? "; estimated with what was measured (--pixel-sigma sets it)" : " as --pixel-sigma says"));
  if (uses) settings->UsePixelSigma(tracks->value);
  return warnings;
}

}  // namespace ch5
