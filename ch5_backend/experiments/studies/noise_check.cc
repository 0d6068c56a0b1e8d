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

}  // namespace

std::optional<MeasuredNoise> NoiseOfSensor(const std::vector<ImuMeasurement>& imu, Vec3 ImuMeasurement::*reading) {
  constexpr double kSeconds = 0.25;  // of a part
  constexpr size_t kFewest = 20;
  constexpr double kQuiet = 0.1, kAlike = 0.75;  // nine in ten parts of white noise have at least 0.89 of the median
  const double dt = (imu.back().t - imu.front().t) / static_cast<double>(imu.size() - 1);
  const size_t length = std::max<size_t>(10, static_cast<size_t>(kSeconds / dt));
  std::vector<double> parts;
  for (size_t first = 0; first + length + 3 <= imu.size(); first += length) {
    double squares = 0.0;
    for (size_t k = first; k < first + length; ++k) {
      const auto x = [&](size_t i) { return imu[k + i].*reading; };
      squares += (x(3) - 3.0 * x(2) + 3.0 * x(1) - x(0)).squaredNorm() / (3.0 * 20.0);  // 1 + 9 + 9 + 1
    }
    parts.push_back(std::sqrt(squares / static_cast<double>(length) * dt));
  }
  if (parts.size() < kFewest) return std::nullopt;
  const double median = Median(parts), quiet = Quantile(parts, kQuiet);
  if (quiet < kAlike * median) return std::nullopt;
  return MeasuredNoise{median, (median - quiet) / std::sqrt(static_cast<double>(parts.size()))};
}

RecordingWarnings CheckNoise(Recording* recording, OdometrySettings* settings) {
  constexpr double kTimes = 1.5, kTimesPixels = 1.15;  // less makes no difference
  RecordingWarnings warnings;
  ImuNoise& noise = recording->calibration.noise;
  const auto check = [&](const std::string& of, const std::string& unit, Vec3 ImuMeasurement::*reading, double* told) {
    const auto found = NoiseOfSensor(recording->imu, reading);
    if (!found || !IsMore(*found, *told, kTimes)) return;
    warnings.push_back(Warning(of + "_noise", of + "'s noise and vibration are", *found, *told, unit + "/√Hz",
                               ", which is imu." + of + "_noise_density; estimated with what was measured"));
    *told = found->value;
  };
  check("gyroscope", "rad/s", &ImuMeasurement::gyroscope, &noise.gyroscope);
  check("accelerometer", "m/s²", &ImuMeasurement::acceleration, &noise.accelerometer);
  const double told = settings->estimator.weights.pixel_sigma;
  const auto tracks = NoiseOfTracks(*recording);
  if (!tracks || !IsMore(*tracks, told, kTimesPixels)) return warnings;
  const bool uses = settings->finds_noise;
  warnings.push_back(
      Warning(uses ? "track_noise" : "track_noise_set", "tracks' noise is", *tracks, told, "px",
              uses ? "; estimated with what was measured (--pixel-sigma sets it)" : " as --pixel-sigma says"));
  if (uses) settings->UsePixelSigma(tracks->value);
  return warnings;
}

}  // namespace ch5
