#include "ch5_backend/evaluate/turn_agreement.h"

#include <algorithm>
#include <array>
#include <map>

#include <Eigen/Cholesky>

namespace ch5 {
namespace {

constexpr double kMostBetween = 0.3;  // [s]
constexpr double kLongestDelay = 0.2, kStep = 0.01;

// The mean rate from one image to another, in C [rad/s].
struct Turn {
  double t0, t1;
  Vec3 rate;
};

// θ of argmin Σ ρ(‖f₀ − f₁ − θ × f₁ − (I − f₁f₁ᵀ) v‖) over the rays that both images have, ρ being Cauchy's; v is the
// translation over the scene's depth, as if all points had the same.
std::optional<Vec3> TurnBetween(const Image& from, const Image& to) {
  constexpr int kFewest = 12, kRounds = 5;
  constexpr double kScale = 3e-3;  // [rad]: a pixel and a half
  std::map<int, Vec3> rays;
  for (const TrackedPoint& point : from.tracks) rays.emplace(point.id, point.x.homogeneous().normalized());
  Vec6 x = Vec6::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Mat66 A = Mat66::Zero();
    Vec6 b = Vec6::Zero();
    int common = 0;
    for (const TrackedPoint& point : to.tracks) {
      const auto ray = rays.find(point.id);
      if (ray == rays.end()) continue;
      const Vec3 f1 = point.x.homogeneous().normalized(), flow = ray->second - f1;
      Eigen::Matrix<double, 3, 6> J;
      J << -Hat(f1), Mat33::Identity() - f1 * f1.transpose();
      const double weight = 1.0 / (1.0 + (flow - J * x).squaredNorm() / (kScale * kScale));
      A += weight * J.transpose() * J;
      b += weight * J.transpose() * flow;
      ++common;
    }
    if (common < kFewest) return std::nullopt;
    x = A.ldlt().solve(b);
  }
  return x.head<3>();
}

// The gyroscope's mean rate, in B; nullopt where it did not measure.
std::optional<Vec3> MeanRate(const std::vector<ImuMeasurement>& imu, double t0, double t1) {
  const std::vector<ImuSample> samples = SamplesBetween(imu, t0, t1);
  if (samples.empty()) return std::nullopt;
  Vec3 turn = Vec3::Zero();
  for (const ImuSample& sample : samples) turn += sample.gyroscope * sample.dt;
  return turn / (t1 - t0);
}

// Of the rates about their means, which hold the gyroscope's bias.
double Correlate(const std::vector<Turn>& turns, const std::vector<ImuMeasurement>& imu, const Mat33& R_B_C,
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
  return a.size() < kFewest || bb < n * kLeast * kLeast || aa == 0.0 ? 0.0 : ab / std::sqrt(aa * bb);
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

std::optional<TurnAgreement> CompareTurns(const Recording& recording) {
  std::vector<Turn> turns;
  for (size_t k = 1; k < recording.images.size(); ++k) {
    const Image &from = recording.images[k - 1], &to = recording.images[k];
    if (to.t - from.t > kMostBetween) continue;
    if (const auto theta = TurnBetween(from, to)) turns.push_back({from.t, to.t, *theta / (to.t - from.t)});
  }
  const Mat33 R_B_C = recording.calibration.T_B_C.q.toRotationMatrix();
  const auto correlate = [&](const Mat33& R, double delay) { return Correlate(turns, recording.imu, R, delay); };
  TurnAgreement result;
  result.as_given = result.at_delay = correlate(R_B_C, 0.0);
  if (result.as_given == 0.0) return std::nullopt;
  result.with_inverse = correlate(R_B_C.transpose(), 0.0);
  for (const Mat33& axes : SignedPermutations()) {  // orthogonal, so that they may as well turn the images' rates back
    const double correlation = correlate(axes.transpose() * R_B_C, 0.0);
    if (correlation > result.with_axes) result.with_axes = correlation, result.axes = axes;
  }
  for (double delay = -kLongestDelay; delay < kLongestDelay + 0.5 * kStep; delay += kStep) {
    const double correlation = correlate(R_B_C, delay);
    if (correlation > result.at_delay) result.at_delay = correlation, result.delay = delay;
  }
  return result;
}

}  // namespace ch5
