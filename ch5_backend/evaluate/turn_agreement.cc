#include "ch5_backend/evaluate/turn_agreement.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include <Eigen/Cholesky>

#include "ch5_backend/math/median.h"

namespace ch5 {
namespace {

// For a pair of images: a rotation must exceed the noise of its rays [s].
constexpr double kLeastBetween = 0.12, kMostBetween = 0.3;
constexpr double kStep = 0.01;
constexpr int kSteps = 125;  // 1.25 s

// The mean rate from one image to another, in C [rad/s].
struct Turn {
  double t0, t1;
  Vec3 rate;
};

constexpr int kRounds = 5;
constexpr double kScale = 3e-3;  // [rad]: a pixel and a half

// The rays f₀ and f₁ of a point that two images see.
using RayPair = std::pair<Vec3, Vec3>;

std::vector<RayPair> CommonRays(const Image& from, const Image& to) {
  std::map<int, Vec3> rays;
  for (const TrackedPoint& point : from.tracks) rays.emplace(point.id, point.x.homogeneous().normalized());
  std::vector<RayPair> common;
  for (const TrackedPoint& point : to.tracks) {
    const auto ray = rays.find(point.id);
    if (ray != rays.end()) common.emplace_back(ray->second, point.x.homogeneous().normalized());
  }
  return common;
}

// One step of Gauss and Newton to argmin Σ ρ(‖r‖).
// @param A          a further term of the Hessian
// @param scale      of Cauchy's loss ρ [rad]
// @param linearize  r and J of a pair of rays
template <typename Linearize>
Vec6 Step(const std::vector<RayPair>& rays, Mat66 A, double scale, const Linearize& linearize) {
  Vec6 b = Vec6::Zero();
  for (const auto& [f0, f1] : rays) {
    const auto [r, J] = linearize(f0, f1);
    const double weight = 1.0 / (1.0 + r.squaredNorm() / (scale * scale));
    A += weight * J.transpose() * J;
    b -= weight * J.transpose() * r;
  }
  return A.ldlt().solve(b);
}

// Rotation θ and translation v between two images, as if all points had the same depth:
// [θ, v] = argmin Σ ρ(‖f₀ − f₁ − θ × f₁ − (I − f₁f₁ᵀ) v‖).
Vec6 MotionOfEqualDepths(const std::vector<RayPair>& rays, double scale) {
  Vec6 x = Vec6::Zero();
  for (int round = 0; round < kRounds; ++round) {
    x += Step(rays, Mat66::Zero(), scale, [&](const Vec3& f0, const Vec3& f1) {
      Eigen::Matrix<double, 3, 6> J;
      J << Hat(f1), f1 * f1.transpose() - Mat33::Identity();
      return std::pair(Vec3(f0 - f1 + J * x), J);
    });
  }
  return x;
}

// The rotation q between two images, whatever the points' depths: with the direction v of the translation it is
// argmin Σ ρ(e), e = vᵀm/s, m = g × f₀, g = q f₁, s² = ½(‖v × g‖² + ‖v × f₀‖²), the distance from the epipolar line.
// Without s, the least would be a v amid the points.
// @return q and v
std::pair<Qd, Vec3> RefineByEpipolarLines(const std::vector<RayPair>& rays, Qd q, Vec3 v, double scale) {
  for (int round = 0; round < kRounds && v.norm() > 0.0; ++round) {
    v.normalize();
    Mat66 length = Mat66::Zero();  // which stays
    length.bottomRightCorner<3, 3>() = v * v.transpose();
    const Vec6 delta = Step(rays, length, scale, [&](const Vec3& f0, const Vec3& f1) {
      const Vec3 g = q * f1, m = g.cross(f0);
      const double s = std::sqrt(0.5 * (v.cross(g).squaredNorm() + v.cross(f0).squaredNorm()) + kScale * kScale);
      const double e = v.dot(m) / s;
      const Vec3 de_dtheta = (v.dot(g) * f0 - f0.dot(g) * v + 0.5 * e / s * v.dot(g) * g.cross(v)) / s;
      const Vec3 de_dv = (m + 0.5 * e / s * (v.dot(g) * g + v.dot(f0) * f0)) / s;
      Eigen::Matrix<double, 1, 6> J;
      J << de_dtheta.transpose(), de_dv.transpose();
      return std::pair(Eigen::Matrix<double, 1, 1>(e), J);
    });
    q = ExpSO3(delta.head<3>()) * q;
    v += delta.tail<3>();
  }
  return {q, v.normalized()};
}

std::pair<Qd, Vec3> MotionBetween(const std::vector<RayPair>& rays, double scale = kScale) {
  const Vec6 start = MotionOfEqualDepths(rays, scale);
  return RefineByEpipolarLines(rays, ExpSO3(start.head<3>()), start.tail<3>(), scale);
}

// |e| = |vᵀ(q f₁ × f₀)| of each point, so that e has its σ in the plane z = 1:  both images' noise is in it, from which the
// fit of a rotation and a direction has taken some.
std::vector<double> EpipolarErrors(const std::vector<RayPair>& rays, double scale) {
  constexpr double kDegrees = 5.0;
  const auto [q, v] = MotionBetween(rays, scale);
  const double left = std::sqrt(1.0 - kDegrees / static_cast<double>(rays.size()));
  std::vector<double> errors;
  for (const auto& [f0, f1] : rays) {
    const Vec3 n0 = v.cross(q * f1), n1 = q.conjugate() * v.cross(f0);  // noise of x moves f by f_z as much
    const double w = std::hypot(n0.head<2>().norm() * f0.z(), n1.head<2>().norm() * f1.z());
    if (w > 0.0) errors.push_back(std::abs(n0.dot(f0)) / (w * left));
  }
  return errors;
}

// Of normal errors among others that lie anywhere.
double SigmaWithoutOutliers(const std::vector<double>& errors) {
  constexpr double kFar = 3.0, kMedian = 0.6724;  // σ; the median of |e|/σ below kFar
  double sigma = Median(errors) / kMedian;
  for (int round = 0; round < 20; ++round) {
    std::vector<double> near;
    std::copy_if(errors.begin(), errors.end(), std::back_inserter(near), [&](double e) { return e <= kFar * sigma; });
    sigma = Median(near) / kMedian;
  }
  return sigma;
}

// nullopt if the images share too few points.
std::optional<Turn> TurnBetween(const Image& from, const Image& to, size_t fewest = 12) {
  const std::vector<RayPair> rays = CommonRays(from, to);
  if (rays.size() < fewest) return std::nullopt;
  return Turn{from.t, to.t, LogSO3(MotionBetween(rays).first) / (to.t - from.t)};
}

template <typename Visit>
void ForPairs(const std::vector<Image>& images, const Visit& visit) {
  for (size_t i = 0, k = 1; k < images.size(); ++k) {
    while (i + 1 < k && images[k].t - images[i + 1].t > kLeastBetween) ++i;
    if (images[k].t - images[i].t <= kMostBetween) visit(images[i], images[k]);
  }
}

// The gyroscope's mean rate, in B; nullopt where it did not measure.
std::optional<Vec3> MeanRate(const std::vector<ImuMeasurement>& imu, double t0, double t1) {
  const std::vector<ImuSample> samples = SamplesBetween(imu, t0, t1);
  if (samples.empty()) return std::nullopt;
  Vec3 turn = Vec3::Zero();
  for (size_t k = 1; k < samples.size(); ++k)
    turn += 0.5 * samples[k].dt * (samples[k - 1].gyroscope + samples[k].gyroscope);
  return turn / (t1 - t0);
}

struct Correlation {
  double value = 0.0;
  double ratio = 0.0;  // of the variances: the images' over the gyroscope's
};

// Of the rates minus their means, which contain the gyroscope's bias.
Correlation Correlate(const std::vector<Turn>& turns, const std::vector<ImuMeasurement>& imu, const Mat33& R_B_C,
                      double delay) {
  constexpr size_t kFewest = 50;
  constexpr double kLeast = 0.05;  // [rad/s]
  std::vector<Vec3> a, b;
  Vec3 mean_a = Vec3::Zero(), mean_b = Vec3::Zero();
  for (const Turn& turn : turns) {
    const auto rate = MeanRate(imu, turn.t0 + delay, turn.t1 + delay);
    if (!rate) continue;
    mean_a += a.emplace_back(R_B_C * turn.rate);
    mean_b += b.emplace_back(*rate);
  }
  const double n = static_cast<double>(a.size());
  double aa = 0.0, ab = 0.0, bb = 0.0;
  for (size_t k = 0; k < a.size(); ++k) {
    const Vec3 x = a[k] - mean_a / n, y = b[k] - mean_b / n;
    aa += x.squaredNorm(), ab += x.dot(y), bb += y.squaredNorm();
  }
  return a.size() < kFewest || bb < n * kLeast * kLeast || aa == 0.0 ? Correlation{}
                                                                     : Correlation{ab / std::sqrt(aa * bb), aa / bb};
}

struct PartDelay {
  double t, delay, weight;
};

// The delay in each part of the recording where it is clear: the top of a parabola through the greatest correlation c and
// those beside it. Of n turns it has the variance (1 − c²) / (n |c″|), and an error that many turns do not lessen.
std::vector<PartDelay> DelaysOfParts(const std::vector<Turn>& turns, const std::vector<ImuMeasurement>& imu,
                                     const Mat33& R_B_C) {
  constexpr size_t kMostParts = 12, kTurns = 60;
  constexpr double kClear = 0.8, kError = 3e-3, kMost = 0.02;  // [s]
  const size_t parts = std::min(kMostParts, turns.size() / kTurns);
  std::vector<PartDelay> delays;
  for (size_t part = 0; part < parts; ++part) {
    const auto at = [&](size_t k) { return turns.begin() + static_cast<std::ptrdiff_t>(k * turns.size() / parts); };
    const std::vector<Turn> some(at(part), at(part + 1));
    std::vector<double> values;
    for (int k = -kSteps; k <= kSteps; ++k) values.push_back(Correlate(some, imu, R_B_C, k * kStep).value);
    const auto best = std::max_element(values.begin(), values.end());
    if (*best < kClear || best == values.begin() || best + 1 == values.end()) continue;
    const double slope = 0.5 * (best[1] - best[-1]), bend = 2.0 * *best - best[-1] - best[1];
    const double variance =
        kError * kError + LeftVariance(*best) / (static_cast<double>(some.size()) * bend) * kStep * kStep;
    if (variance > kMost * kMost) continue;
    delays.push_back({0.5 * (some.front().t0 + some.back().t1),
                      (static_cast<double>(best - values.begin()) - kSteps + slope / bend) * kStep, 1.0 / variance});
  }
  return delays;
}

// The image at whose stamp the delay changes: before it the turns are the gyroscope's after one delay, from it on after another.
double TimeOfStep(const std::vector<Turn>& turns, const std::vector<ImuMeasurement>& imu, const Mat33& R_B_C,
                  double delay_before, double delay_after) {
  const auto error = [&](const Turn& turn, double delay) {
    const auto rate = MeanRate(imu, turn.t0 + delay, turn.t1 + delay);
    return rate ? (R_B_C * turn.rate - *rate).squaredNorm() : 0.0;
  };
  double sum = 0.0, least = 0.0, t = turns.front().t0;
  for (const Turn& turn : turns) {
    sum += error(turn, delay_before) - error(turn, delay_after);
    if (sum < least) least = sum, t = turn.t1;
  }
  return t;
}

// The parts' delays by least squares, delay + rate (t − mean of t), or the same all along.
struct DelayFit {
  double weight = 0.0, t = 0.0, delay = 0.0;     // the sum of the weights, and means
  double scatter = 0.0, rate = 0.0, left = 0.0;  // Σ w (t − mean)²; Σ w (what is not explained)²

  DelayFit(const PartDelay* first, const PartDelay* last, bool is_constant) {
    const auto sum = [&](const auto& value) {
      return std::accumulate(first, last, 0.0,
                             [&](double all, const PartDelay& part) { return all + part.weight * value(part); });
    };
    weight = sum([](const PartDelay&) { return 1.0; });
    t = sum([](const PartDelay& part) { return part.t; }) / weight;
    delay = sum([](const PartDelay& part) { return part.delay; }) / weight;
    scatter = sum([&](const PartDelay& part) { return std::pow(part.t - t, 2); });
    if (!is_constant) rate = sum([&](const PartDelay& part) { return part.delay * (part.t - t); }) / scatter;
    left = sum([&](const PartDelay& part) { return std::pow(part.delay - delay - rate * (part.t - t), 2); });
  }
};

// A line through the parts' delays, or two levels if these fit them far better.
std::optional<DelayChange> ChangeOfDelay(const std::vector<Turn>& turns, const std::vector<ImuMeasurement>& imu,
                                         const Mat33& R_B_C) {
  constexpr ptrdiff_t kFewest = 4;
  constexpr double kSigmas = 6.0;   // the rate is at most 1.5 of its σ in recordings that are in order
  constexpr double kLeast = 0.015;  // of the delay's change [s]
  constexpr double kTimesBetter = 4.0;
  constexpr double kMostRate = 0.01;  // of clocks that are meant to run alike
  const std::vector<PartDelay> parts = DelaysOfParts(turns, imu, R_B_C);
  const auto n = static_cast<ptrdiff_t>(parts.size());
  if (n < kFewest) return std::nullopt;
  const PartDelay *const first = parts.data(), *const last = first + n;
  const auto scale = [&](double chi2) { return std::max(1.0, std::sqrt(chi2 / static_cast<double>(n - 2))); };
  const DelayFit line(first, last, false);
  DelayChange step;
  double left = line.left / kTimesBetter;
  for (const PartDelay* split = first + 2; split + 2 <= last; ++split) {
    const DelayFit before(first, split, true), after(split, last, true);
    if (before.left + after.left >= left) continue;
    left = before.left + after.left;
    step.step = after.delay - before.delay;
    step.delay = after.delay;
    step.sigma = scale(left) * std::sqrt(1.0 / before.weight + 1.0 / after.weight);
  }
  if (std::abs(step.step) > std::max(kLeast, kSigmas * step.sigma)) {
    step.t = TimeOfStep(turns, imu, R_B_C, step.delay - step.step, step.delay);
    return step;
  }
  const double sigma = scale(line.left) / std::sqrt(line.scatter), rate = std::abs(line.rate);
  if (rate < std::max(kLeast / (parts.back().t - parts.front().t), kSigmas * sigma) || rate > kMostRate)
    return std::nullopt;
  return DelayChange{line.rate, 0.0, line.t, line.delay, sigma};
}

}  // namespace

std::vector<Mat33> SignedPermutations() {
  std::vector<Mat33> all;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Mat33 P = Mat33::Zero();
      for (int row = 0; row < 3; ++row) P(row, order[static_cast<size_t>(row)]) = signs >> row & 1 ? -1.0 : 1.0;
      all.push_back(P);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

std::string NameAxes(const Mat33& axes) {
  std::string names;
  for (int row = 0; row < 3; ++row) {
    Eigen::Index column;
    axes.row(row).cwiseAbs().maxCoeff(&column);
    names += std::string(row > 0 ? ", " : "") + (axes(row, column) < 0.0 ? "-" : "") + "xyz"[column];
  }
  return names;
}

Vec3 SpreadOfImageTurns(const Recording& recording) {
  constexpr double kMost = 10.0;    // [rad/s]: faster ones are none
  constexpr double kOverlap = 3.0;  // of the pairs of images, of which so many are one measurement
  constexpr double kSure = 5.0;     // σ
  constexpr size_t kFewest = 8;     // points of a half
  const Mat33 R_B_C = recording.calibration.T_B_C.q.toRotationMatrix();
  std::vector<std::pair<Vec3, Vec3>> rates;
  Vec3 mean_a = Vec3::Zero(), mean_b = Vec3::Zero();
  const auto half = [](Image image, int parity) {
    const auto is_other = [&](const TrackedPoint& point) { return point.id % 2 != parity; };
    image.tracks.erase(std::remove_if(image.tracks.begin(), image.tracks.end(), is_other), image.tracks.end());
    return image;
  };
  ForPairs(recording.images, [&](const Image& from, const Image& to) {
    const auto a = TurnBetween(half(from, 0), half(to, 0), kFewest),
               b = TurnBetween(half(from, 1), half(to, 1), kFewest);
    if (!a || !b || a->rate.norm() > kMost || b->rate.norm() > kMost) return;
    mean_a += R_B_C * a->rate, mean_b += R_B_C * b->rate;
    rates.emplace_back(R_B_C * a->rate, R_B_C * b->rate);
  });
  const double n = static_cast<double>(rates.size());
  Vec3 aa = Vec3::Zero(), ab = Vec3::Zero(), bb = Vec3::Zero();
  for (const auto& [a, b] : rates) {
    const Vec3 x = a - mean_a / n, y = b - mean_b / n;
    aa += x.cwiseAbs2(), ab += x.cwiseProduct(y), bb += y.cwiseAbs2();
  }
  Vec3 spread = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {  // of noise alone, a correlation of n pairs has σ² = 1/n
    const double sigma = std::sqrt(kOverlap / n * aa[axis] * bb[axis]);
    if (ab[axis] > kSure * sigma) spread[axis] = std::sqrt(ab[axis] / n);
  }
  return spread;
}

std::optional<MeasuredNoise> NoiseOfTracks(const Recording& recording) {
  constexpr size_t kParts = 8, kPairs = 400;
  constexpr size_t kFewestRays = 12, kFewestErrors = 100;
  constexpr double kWide = 3.0;  // a narrower loss fits the noise of a few
  std::vector<std::vector<RayPair>> pairs;
  ForPairs(recording.images, [&](const Image& from, const Image& to) {
    std::vector<RayPair> rays = CommonRays(from, to);
    if (rays.size() >= kFewestRays) pairs.push_back(std::move(rays));
  });
  std::vector<double> sigmas;  // of the parts, in the plane z = 1
  double scale = kScale;
  for (int round = 0; round < 3; ++round) {
    std::array<std::vector<double>, kParts> errors;
    for (size_t k = 0; k < pairs.size(); k += pairs.size() / kPairs + 1) {
      const std::vector<double> more = EpipolarErrors(pairs[k], scale);
      std::vector<double>& part = errors[k * kParts / pairs.size()];
      part.insert(part.end(), more.begin(), more.end());
    }
    sigmas.clear();
    for (const std::vector<double>& part : errors)
      if (part.size() >= kFewestErrors) sigmas.push_back(SigmaWithoutOutliers(part));
    if (sigmas.size() < kParts / 2) return std::nullopt;
    scale = kWide * std::sqrt(2.0) * Median(sigmas);
  }
  const VecX pixels = recording.calibration.FocalLength() *
                      Eigen::Map<const VecX>(sigmas.data(), static_cast<Eigen::Index>(sigmas.size()));
  const double n = static_cast<double>(pixels.size());
  return MeasuredNoise{pixels.mean(), std::sqrt((pixels.array() - pixels.mean()).square().sum() / (n * (n - 1.0)))};
}

std::optional<TurnAgreement> CompareTurns(const Recording& recording) {
  std::vector<Turn> turns;
  ForPairs(recording.images, [&](const Image& from, const Image& to) {
    if (const auto turn = TurnBetween(from, to)) turns.push_back(*turn);
  });
  const Mat33 R_B_C = recording.calibration.T_B_C.q.toRotationMatrix();
  const auto correlate = [&](const Mat33& R, double delay) { return Correlate(turns, recording.imu, R, delay).value; };
  TurnAgreement result;
  const Correlation given = Correlate(turns, recording.imu, R_B_C, 0.0);
  if (given.value == 0.0) return std::nullopt;
  result.as_given = result.at_delay = given.value;
  result.noise = given.ratio;
  double seconds = 0.0;
  for (const Turn& turn : turns) seconds += turn.t1 - turn.t0;
  result.pairs = (turns.back().t1 - turns.front().t0) * static_cast<double>(turns.size()) / seconds;
  result.with_inverse = correlate(R_B_C.transpose(), 0.0);
  for (const Mat33& axes : SignedPermutations()) {  // orthogonal, so that they may as well turn the images' rates back
    const double correlation = correlate(axes.transpose() * R_B_C, 0.0);
    if (correlation > result.with_axes) result.with_axes = correlation, result.axes = axes;
    if (axes(2, 2) != 1.0 || axes.isIdentity()) continue;
    const double of_tracks = correlate(axes.determinant() * R_B_C * axes, 0.0);  // a turn is an axial vector
    if (of_tracks > result.with_tracks)
      result.with_tracks = of_tracks, result.tracks = NameAxes(axes).substr(0, NameAxes(axes).rfind(','));
  }
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double delay = k * kStep;
    const double correlation = correlate(R_B_C, delay);
    if (correlation > result.at_delay) result.at_delay = correlation, result.delay = delay;
  }
  result.change = ChangeOfDelay(turns, recording.imu, R_B_C);
  return result;
}

bool TurnOtherwise(const TurnAgreement& turns) {
  // 0.63 or more and 0.98 to 2.8 in recordings that are in order, but 0.06 to 0.37 and 20 to 66 for a car on a straight road.
  constexpr double kPoor = 0.4, kMostNoise = 6.0;
  const bool is_poor = turns.at_delay < kPoor || (turns.as_given < kPoor && !ClearDelay(turns));
  return is_poor && turns.noise < kMostNoise;
}

std::optional<double> ClearDelay(const TurnAgreement& turns) {
  constexpr double kLeast = 0.015, kMost = (kSteps - 1.5) * kStep;  // [s]; what rises to the search's end is none
  // A delay's gain grows with its square, from 1.05 to 1.5 at 20 ms. Where the camera turns slowly, noise looks like a delay of
  // 40 to 90 ms, with a gain of up to 1.07.
  constexpr double kGain = 0.05, kDelayOfGain = 0.04,
                   kMostGain = 0.5;  // two turns farther apart have nothing in common
  // By chance a delay gains up to 5/n of n pairs of images.
  constexpr double kByChance = 6.0;
  // The best of a hundred places need not be a good one.
  constexpr double kFar = 0.2, kGood = 0.6;
  const double delay = std::abs(turns.delay), gain = LeftVariance(turns.as_given) / LeftVariance(turns.at_delay) - 1.0;
  if (delay < kLeast || delay > kMost ||
      gain < std::min(kMostGain,
                      std::max(kByChance / turns.pairs, kGain * std::max(1.0, std::pow(delay / kDelayOfGain, 2)))))
    return std::nullopt;
  if (delay > kFar && turns.at_delay < kGood) return std::nullopt;
  return turns.delay;
}

}  // namespace ch5
