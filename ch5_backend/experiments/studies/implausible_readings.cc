#include "ch5_backend/experiments/studies/implausible_readings.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iomanip>
#include <limits>
#include <map>
#include <sstream>

#include "ch5_backend/evaluate/turn_agreement.h"
#include "ch5_backend/experiments/studies/recording_warnings.h"
#include "ch5_backend/math/median.h"

namespace ch5 {
namespace {

using Readings = std::vector<ImuMeasurement>;
using Reading = Vec3 ImuMeasurement::*;

struct Sensor {
  std::string name, unit;
  Reading reading;
  double ImuNoise::*density;
  double least_rail;   // the smallest ranges are 125°/s and 2 g; below, more is asked
  double least_spike;  // in 5 ms this spoils an estimate by 0.1° or 1 cm/s
};
const Sensor kSensors[] = {
    {"gyroscope", "rad/s", &ImuMeasurement::gyroscope, &ImuNoise::gyroscope, 1.5, 0.5},
    {"accelerometer", "m/s²", &ImuMeasurement::acceleration, &ImuNoise::accelerometer, 15.0, 5.0}};

// Noise turns a step back as often as not; a motion alone does not, and may stand still, jump or turn evenly.
bool IsNoisy(const Readings& imu, Reading reading) {
  constexpr double kLeastShare = 0.05;
  Vec3 last = Vec3::Zero();
  size_t steps = 0, back = 0;
  for (size_t k = 1; k < imu.size(); ++k) {
    const Vec3 step = imu[k].*reading - imu[k - 1].*reading;
    if (step.isZero(0.0)) continue;
    ++steps;
    if (step.dot(last) < 0.0) ++back;
    last = step;
  }
  return static_cast<double>(back) > kLeastShare * static_cast<double>(steps);
}

struct Held {
  size_t first, length;
};

std::vector<Held> RunsOfEqual(const Readings& imu, Reading reading) {
  std::vector<Held> runs;
  for (size_t k = 0; k < imu.size(); ++k) {
    if (k == 0 || imu[k].*reading != imu[k - 1].*reading) runs.push_back({k, 0});
    ++runs.back().length;
  }
  return runs;
}

// In how many readings each value of a sensor stands, in the mean, as where a slow sensor is read at a fast one's rate or a log
// is filled up to a rate; 1: it does not. Rounded values of three axes repeat each for itself: of n readings all three at once
// by chance in n p₁ p₂ p₃, if p are the axes' shares. More is asked of all tenths of a second or so together: at the end of a
// rest, a sensor without noise repeats more in one of them.
double HeldFor(const Readings& imu, Reading reading) {
  constexpr size_t kPart = 20;
  constexpr double kSure = 6.0, kLeast = 1.05;  // a driver that repeats a reading or two does no harm
  double repeats = 0.0, parts = 0.0, more = 0.0, squares = 0.0;
  for (size_t first = 1; first + kPart <= imu.size(); first += kPart) {
    Vec3 alone = Vec3::Zero();
    double together = 0.0;
    for (size_t k = first; k < first + kPart; ++k) {
      const Vec3 same = (imu[k].*reading).cwiseEqual(imu[k - 1].*reading).cast<double>();
      alone += same;
      together += same.prod();
    }
    const double beyond_chance = together - alone.prod() / static_cast<double>(kPart * kPart);  // 20 · Π (count / 20)
    repeats += together, parts += 1.0, more += beyond_chance, squares += beyond_chance * beyond_chance;
  }
  const double variance = squares - more * more / std::max(1.0, parts);  // of the sum
  if (more <= kSure * std::sqrt(std::max(0.0, variance)) || more == 0.0) return 1.0;
  const double n = static_cast<double>(imu.size()), held_for = n / (n - repeats);
  return held_for < kLeast ? 1.0 : held_for;
}

// Where a noisy sensor stands still and then jumps, and where it feels not even gravity. A coarse one may stand still at
// rest, but its next value is beside.
void MarkStuck(const Readings& imu, const Sensor& sensor, std::vector<bool>* is_out) {
  constexpr size_t kFewest = 5;  // a driver that repeats a reading or two does no harm
  constexpr double kJump = 0.5;  // of the median step, which noise exceeds nearly always at one of the ends
  constexpr double kLeastForce = 1.0;
  const std::vector<Held> runs = RunsOfEqual(imu, sensor.reading);
  if (runs.size() < 2 || !IsNoisy(imu, sensor.reading)) return;
  const auto step = [&](size_t k) {
    return k == 0 || k == imu.size() ? 0.0 : (imu[k].*sensor.reading - imu[k - 1].*sensor.reading).norm();
  };
  std::vector<double> steps;
  for (size_t i = 1; i < runs.size(); ++i) steps.push_back(step(runs[i].first));
  const double resolution = *std::min_element(steps.begin(), steps.end());
  const double least = std::max(kJump * Median(steps), 2.0 * resolution);
  Vec3 least_of_all = imu[0].*sensor.reading, most_of_all = least_of_all;
  for (const ImuMeasurement& m : imu) {
    least_of_all = least_of_all.cwiseMin(m.*sensor.reading);
    most_of_all = most_of_all.cwiseMax(m.*sensor.reading);
  }
  const auto is_at_rails = [&](const Vec3& x) {
    return ((x.array() == least_of_all.array()) || (x.array() == most_of_all.array())).all();
  };
  const size_t fewest = std::max(kFewest, static_cast<size_t>(3.0 * HeldFor(imu, sensor.reading)));
  for (const auto& [first, length] : runs) {
    const double before = step(first), after = step(first + length);
    const bool is_zero = sensor.reading == &ImuMeasurement::acceleration && (imu[first].*sensor.reading).isZero(0.0) &&
                         (first == 0 || before > kLeastForce) && (first + length == imu.size() || after > kLeastForce);
    const bool is_plausible =
        length < fewest || std::max(before, after) <= least || is_at_rails(imu[first].*sensor.reading);
    if (!is_zero && is_plausible) continue;
    const size_t kept = is_zero ? 0 : 1;
    std::fill_n(is_out->begin() + static_cast<std::ptrdiff_t>(first + kept), length - kept, true);
  }
}

// Where the extreme is no sensor's range: ten times as many readings as share another value near it; of a coarse sensor, many do.
template <typename Value>
double ManyMoreThanOthers(size_t n, const Value& value, double extreme) {
  constexpr double kTimes = 10.0, kNear = 0.8, kFewestOthers = 3.0;
  std::map<double, double> counts;
  for (size_t k = 0; k < n; ++k)
    if (value(k) > kNear * extreme && value(k) < extreme) ++counts[value(k)];
  const auto others = static_cast<double>(counts.size());
  double all = 0.0;
  for (const auto& [x, count] : counts) all += count;
  return others < kFewestOthers ? std::numeric_limits<double>::infinity() : kTimes * all / others;
}

// What many readings of one axis share that are extreme in one direction: their value, which is behind a calibration,
// x = c₀ + c₁ y + c₂ z, exact as no noise is.
struct Rail {
  double value = 0.0;
  std::vector<size_t> readings;
};
Rail FindRail(const Readings& imu, const Sensor& sensor, int axis, double sign, bool is_sure) {
  constexpr double kNear = 0.97, kExact = 1e-5, kShare = 0.5;
  constexpr double kFewest = 5.0;
  const auto value = [&](size_t k) { return sign * (imu[k].*sensor.reading)[axis]; };
  double extreme = 0.0;
  for (size_t k = 0; k < imu.size(); ++k) extreme = std::max(extreme, value(k));
  if (extreme <= 0.0) return {};
  const double fewest = is_sure && extreme >= sensor.least_rail
                            ? kFewest
                            : std::max(kFewest, ManyMoreThanOthers(imu.size(), value, extreme));
  std::vector<size_t> near;
  for (size_t k = 0; k < imu.size(); ++k)
    if (value(k) > kNear * extreme) near.push_back(k);
  const auto row = [&](size_t k) {
    return Vec3(1.0, (imu[k].*sensor.reading)[(axis + 1) % 3], (imu[k].*sensor.reading)[(axis + 2) % 3]);
  };
  Vec3 c(extreme, 0.0, 0.0);
  const auto error = [&](size_t k) { return std::abs(value(k) - c.dot(row(k))); };
  for (double width = extreme; width > 1e-9; width *= 0.5) {  // argmin Σ |error|
    Rail rail{extreme, {}};
    std::copy_if(near.begin(), near.end(), std::back_inserter(rail.readings),
                 [&](size_t k) { return error(k) < kExact * extreme; });
    const auto count = static_cast<double>(rail.readings.size());
    if (count >= fewest && count > kShare * static_cast<double>(near.size())) return rail;
    Mat33 A = 1e-12 * Mat33::Identity();
    Vec3 b = Vec3::Zero();
    for (const size_t k : near) {
      const double weight = 1.0 / (error(k) + width);
      A += weight * row(k) * row(k).transpose();
      b += weight * value(k) * row(k);
    }
    c = A.ldlt().solve(b);
  }
  return {};
}

// The readings at a rail, of which it warns.
std::vector<size_t> CheckRails(const Readings& imu, const Sensor& sensor, RecordingWarnings* warnings) {
  std::vector<size_t> all;
  const bool is_noisy = IsNoisy(imu, sensor.reading);
  for (int axis = 0; axis < 3; ++axis) {
    Rail rail = FindRail(imu, sensor, axis, 1.0, is_noisy);
    const Rail down = FindRail(imu, sensor, axis, -1.0, is_noisy);
    // Without noise, a motion may hold a rate; but hardly the same in both directions.
    if (!is_noisy && (rail.readings.empty() || rail.value != down.value)) continue;
    rail.value = std::max(rail.value, down.value);
    rail.readings.insert(rail.readings.end(), down.readings.begin(), down.readings.end());
    if (rail.readings.empty()) continue;
    const std::string name(1, "xyz"[axis]);
    warnings->push_back(
        {sensor.name + "_rail", rail.value, static_cast<double>(rail.readings.size()),
         Join("the ", sensor.name, " is at its limit on axis ", name, " in ", rail.readings.size(), " readings, ±",
              rail.value, " ", sensor.unit, ": the motion was faster, and the estimates err there"),
         name});
    all.insert(all.end(), rail.readings.begin(), rail.readings.end());
  }
  return all;
}

// One reading or two far from the median of those around, as nothing near is: a blow lasts and rings.
void MarkSpikes(const Readings& imu, const Sensor& sensor, std::vector<bool>* is_out) {
  constexpr double kTimes = 5.0;
  constexpr size_t kBeside = 2;                 // of the median, on each side
  constexpr size_t kAround = 100, kOthers = 3;  // of those around the fourth counts: spikes come in pairs
  std::vector<double> stands_out(imu.size(), 0.0);
  for (size_t k = kBeside; k + kBeside < imu.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      for (size_t i = k - kBeside; i <= k + kBeside; ++i) values.push_back((imu[i].*sensor.reading)[axis]);
      stands_out[k] = std::max(stands_out[k], std::abs(values[kBeside] - Median(values)));
    }
  }
  for (size_t k = 0; k < imu.size(); ++k) {
    if (stands_out[k] < sensor.least_spike) continue;
    const size_t first = k > kAround ? k - kAround : 0, last = std::min(imu.size(), k + kAround);
    std::vector<double> around(stands_out.begin() + static_cast<std::ptrdiff_t>(first),
                               stands_out.begin() + static_cast<std::ptrdiff_t>(last));
    if (around.size() <= kOthers) continue;
    std::nth_element(around.begin(), around.begin() + kOthers, around.end(), std::greater<double>());
    if (stands_out[k] > kTimes * around[kOthers]) (*is_out)[k] = true;
  }
}

// Linear between the values that are new.
void Interpolate(Reading reading, const std::vector<Held>& runs, double held_for, Readings* imu) {
  for (size_t i = 0; i + 1 < runs.size(); ++i) {
    const auto [first, length] = runs[i];
    const ImuMeasurement from = (*imu)[first], to = (*imu)[first + length];
    if (static_cast<double>(length) > 2.0 * held_for) continue;
    for (size_t k = first + 1; k < first + length; ++k)
      (*imu)[k].*reading = from.*reading + ((*imu)[k].t - from.t) / (to.t - from.t) * (to.*reading - from.*reading);
  }
}

// Whether an axis holds no motion: it is constant, or white noise. Of that n Σ ρ² over the correlations ρ at L delays has the mean
// L and the variance 2L (Box and Pierce 1970), of an axis that feels something a hundred times as much.
bool IsWhite(const std::vector<double>& values) {
  constexpr size_t kDelays = 20;
  constexpr double kSigmas = 5.0;
  const auto x = Eigen::Map<const VecX>(values.data(), static_cast<Eigen::Index>(values.size()));
  const VecX centered = x.array() - x.mean();
  const double squares = centered.squaredNorm();
  const bool is_constant = squares <= 1e-20 * x.squaredNorm();
  if (values.size() < 10 * kDelays || is_constant) return is_constant;
  double sum = 0.0;
  for (Eigen::Index delay = 1; delay <= static_cast<Eigen::Index>(kDelays); ++delay) {
    const Eigen::Index n = centered.size() - delay;
    const double correlation = centered.head(n).dot(centered.tail(n)) / squares;
    sum += static_cast<double>(centered.size()) * correlation * correlation;
  }
  return sum < kDelays + kSigmas * std::sqrt(2.0 * kDelays);
}

// Gravity by the gyroscope, whose drift the accelerometer takes back within seconds, at each reading once the guess that it begins
// with is forgotten.
std::vector<Vec3> GravityByTurns(const Readings& imu) {
  constexpr double kSeconds = 2.0, kForgotten = 6.0;
  const double begin = imu.front().t + std::min(kForgotten, 0.5 * (imu.back().t - imu.front().t));
  Vec3 g = Vec3::Zero();
  for (const ImuMeasurement& m : imu) g += m.acceleration / static_cast<double>(imu.size());
  std::vector<Vec3> all;
  for (size_t k = 1; k < imu.size(); ++k) {
    const double dt = std::min(imu[k].t - imu[k - 1].t, kSeconds);
    g = ExpSO3(-dt * imu[k].gyroscope) * g + dt / kSeconds * (imu[k].acceleration - g);
    if (imu[k].t >= begin) all.push_back(g);
  }
  return all;
}

Vec3 SpreadOf(const std::vector<Vec3>& values) {
  const auto n = static_cast<double>(values.size());
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero();
  for (const Vec3& x : values) sum += x, squares += x.cwiseAbs2();
  return (squares / n - (sum / n).cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
}

// Whether the accelerometer feels as much gravity as it should. In recordings that are in order it is within 2 %: accelerations
// of a body that stays near are without a mean.
void CheckGravity(const Recording& recording, RecordingWarnings* warnings) {
  constexpr double kShare = 0.06, kOfReadings = 0.5;
  std::vector<double> felt, lengths;
  for (const Vec3& g : GravityByTurns(recording.imu)) felt.push_back(g.norm());
  for (const ImuMeasurement& m : recording.imu) lengths.push_back(m.acceleration.norm());
  if (felt.empty()) return;
  const double told = recording.calibration.gravity, off = Median(felt) - told;
  // An axis with the wrong sign, or a gyroscope at fault, shortens what is turned and averaged, but no reading.
  if (std::abs(off) < kShare * told || (Median(lengths) - told) / off < kOfReadings) return;
  warnings->push_back({"gravity", told + off, told,
                       Join("the accelerometer feels ", told + off, " m/s² of gravity, not ", told,
                            ", which is imu.gravity: are its unit, scale factor and bias right?")});
}

// A robot on a plane tilts about no axis: so the images must turn about the gyroscope's, and gravity, by the gyroscope, move
// along the accelerometer's.
void CheckDeadAxes(const Recording& recording, RecordingWarnings* warnings) {
  constexpr double kLeastTurn = 0.05;   // [rad/s]
  constexpr double kLeastForce = 0.12;  // of gravity, along an axis [m/s²]
  constexpr double kSlowest = 0.015;    // [s]: a slower IMU makes white noise of vibration
  const Readings& imu = recording.imu;
  if (imu.back().t - imu.front().t > kSlowest * static_cast<double>(imu.size())) return;
  const auto check = [&](const Sensor& sensor, double least, const auto& spread_of) {
    std::string silent, dead;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      for (const ImuMeasurement& m : imu) values.push_back((m.*sensor.reading)[axis]);
      if (IsWhite(values)) silent += "xyz"[axis];
    }
    if (silent.empty()) return;
    const Vec3 spread = spread_of();
    for (const char axis : silent)
      if (spread[axis - 'x'] > least) dead += (dead.empty() ? "" : ", ") + std::string(1, axis);
    if (dead.empty()) return;
    warnings->push_back(
        {sensor.name + "_dead", spread.maxCoeff(), kNoNumber,
         Join("the ", sensor.name, " feels nothing on axis ", dead, " all along, though the body turns"), dead});
  };
  check(kSensors[0], kLeastTurn, [&] { return SpreadOfImageTurns(recording); });
  check(kSensors[1], kLeastForce, [&] { return SpreadOf(GravityByTurns(recording.imu)); });
}

// Its rails and its spikes; between values that are held for several readings, the readings are interpolated.
void CheckSensor(const Sensor& sensor, Recording* recording, std::vector<bool>* is_out, RecordingWarnings* warnings) {
  Readings& imu = recording->imu;
  const std::vector<size_t> at_rail = CheckRails(imu, sensor, warnings);
  // Spikes of a sensor that is read too often last as long as its other values.
  if (const double held_for = HeldFor(imu, sensor.reading); held_for > 1.0) {
    const std::vector<Held> runs = RunsOfEqual(imu, sensor.reading);
    const double rate = static_cast<double>(runs.size()) / (imu.back().t - imu.front().t);
    warnings->push_back({sensor.name + "_held", rate, held_for,
                         Join("the ", sensor.name, " measures at ", rate, " Hz: each value stands in ", held_for,
                              " readings in the mean; the estimators interpolate between them")});
    Interpolate(sensor.reading, runs, held_for, &imu);
    recording->calibration.noise.*sensor.density *= std::sqrt(held_for);  // as noisy values are so many times fewer
  }
  MarkSpikes(imu, sensor, is_out);
  for (const size_t k : at_rail) (*is_out)[k] = false;
}

}  // namespace

RecordingWarnings CheckReadings(const std::string& path, std::vector<int> lines, bool strict, Recording* recording) {
  RecordingWarnings warnings;
  Readings& imu = recording->imu;
  const auto leave_out = [&](const std::vector<bool>& is_out, const std::string& name, const std::string& what) {
    const auto first = static_cast<size_t>(std::find(is_out.begin(), is_out.end(), true) - is_out.begin());
    const auto count = std::count(is_out.begin(), is_out.end(), true);
    if (first == is_out.size() || static_cast<size_t>(count) + 2 > imu.size()) return;
    std::ostringstream place;
    place << path << ":" << lines[first] << ": at " << std::fixed << std::setprecision(3) << imu[first].t
          << " s, w = " << imu[first].gyroscope.transpose() << ", a = " << imu[first].acceleration.transpose();
    if (strict) throw FileError(Join(place.str(), ": IMU readings that cannot be: ", what));
    warnings.push_back({name, static_cast<double>(count), imu[first].t,
                        Join("IMU readings left out: ", count, "; ", what, "; the first: ", place.str()), place.str(),
                        imu[first].t});
    size_t kept = 0;
    for (size_t k = 0; k < imu.size(); ++k) {
      if (is_out[k]) continue;
      lines[kept] = lines[k];
      imu[kept++] = imu[k];
    }
    imu.resize(kept);
  };
  std::vector<bool> is_out(imu.size(), false);
  for (const Sensor& sensor : kSensors) MarkStuck(imu, sensor, &is_out);
  leave_out(is_out, "imu_stuck", "their values are zero or repeat those before");

  is_out.assign(imu.size(), false);
  for (const Sensor& sensor : kSensors) CheckSensor(sensor, recording, &is_out, &warnings);
  leave_out(is_out, "imu_spike", "each is far from both its neighbors");
  CheckDeadAxes(*recording, &warnings);
  if (warnings.empty()) CheckGravity(*recording, &warnings);  // by turns that a rail or a gap would spoil
  return warnings;
}

}  // namespace ch5
