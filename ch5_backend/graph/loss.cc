#include "ch5_backend/graph/loss.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "ch5_backend/math/dispatch.h"

namespace ch5 {
namespace {

double RequirePositive(double threshold) {
  if (threshold > 0.0 && std::isfinite(threshold)) return threshold;
  throw std::invalid_argument("a loss's threshold must be positive and finite, got " + std::to_string(threshold));
}

// 2ρ'' where ρ' + 2ρ''s is positive. Huber's is zero; the margin keeps its rounding from switching the term on and off.
double RankOne(double slope, double curvature, double s) {
  constexpr double kMargin = 1e-12;
  return slope + 2.0 * curvature * s > kMargin * slope ? 2.0 * curvature : 0.0;
}

}  // namespace

double LossFunction::Sum(const double* s, int n) const {
  double sum = 0.0;
  for (int k = 0; k < n; ++k) sum += Evaluate(s[k])[0];
  return sum;
}

void LossFunction::Weigh(const double* s, int n, double* weight, double* rank_one) const {
  for (int k = 0; k < n; ++k) {
    const RobustWeight robust = CorrectLoss(EvaluateSlopes(s[k]), s[k], correction_);
    weight[k] = robust.weight;
    rank_one[k] = robust.rank_one;
  }
}

ThresholdLoss::ThresholdLoss(double threshold, LossCorrection correction)
    : LossFunction(correction), threshold_(RequirePositive(threshold)), square_(threshold * threshold) {}

Rho HuberLoss::Evaluate(double s) const {
  if (s <= square_) return {s, 1.0, 0.0};
  const double root = std::sqrt(s);
  const double slope = threshold_ / root;
  return {2.0 * threshold_ * root - square_, slope, -0.5 * slope / s};
}

Rho CauchyLoss::Evaluate(double s) const {
  const Rho slopes = EvaluateSlopes(s);
  return {square_ * std::log1p(s / square_), slopes[1], slopes[2]};
}

Rho CauchyLoss::EvaluateSlopes(double s) const {
  const double slope = square_ / (square_ + s);
  return {s, slope, -slope * slope / square_};
}

namespace {

// Π(1 + x_k) − 1 for x = s/δ². It grows by x + qx: all terms are positive, so that no digits of small x are lost.
struct CauchyProduct {
  using Signature = double(const double* s, int n, double square);
  template <SimdLevel kSimd>
  static CH5_INLINE double Run(const double* s, int n, double square) {
    using Vector = FittingLanes<kSimd>;
    constexpr int kWidth = sizeof(Vector) / sizeof(double);
    Vector products = {}, x;
    int k = 0;
    for (; k + kWidth <= n; k += kWidth) {
      Load(s + k, &x);
      x = x / square;
      products += x + products * x;
    }
    double q[kWidth];
    Store(products, q);
    CH5_UNROLL
    for (int half = kWidth / 2; half > 0; half /= 2) {
      CH5_UNROLL
      for (int i = 0; i < half; ++i) q[i] += q[i + half] + q[i] * q[i + half];
    }
    for (; k < n; ++k) q[0] += s[k] / square + q[0] * (s[k] / square);
    return q[0];
  }
};

// ρ' = 1 / (1 + s/δ²)
struct CauchySlopes {
  using Signature = void(const double* s, int n, double square, double* slope);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(const double* s, int n, double square, double* slope) {
    using Vector = FittingLanes<kSimd>;
    constexpr int kWidth = sizeof(Vector) / sizeof(double);
    int k = 0;
    for (; k + kWidth <= n; k += kWidth) {
      Vector s_k;
      Load(s + k, &s_k);
      Store(square / (square + s_k), slope + k);
    }
    for (; k < n; ++k) slope[k] = square / (square + s[k]);
  }
};

}  // namespace

// One logarithm for many: Σ log(1 + x_k) = log Π(1 + x_k). 64 factors leave a relative error below 130 ε.
double CauchyLoss::Sum(const double* s, int n) const {
  constexpr int kAtOnce = 64;
  const auto product = Dispatch<CauchyProduct>();
  double sum = 0.0;
  for (int first = 0; first < n; first += kAtOnce) {
    const int count = std::min(n - first, kAtOnce);
    const double q = product(s + first, count, square_);
    sum += std::isfinite(q) ? square_ * std::log1p(q) : LossFunction::Sum(s + first, count);
  }
  return sum;
}

void CauchyLoss::Weigh(const double* s, int n, double* weight, double* rank_one) const {
  Dispatch<CauchySlopes>()(s, n, square_, weight);
  std::fill_n(rank_one, n, 0.0);
  if (Correction() != LossCorrection::kTriggs) return;
  for (int k = 0; k < n; ++k) rank_one[k] = RankOne(weight[k], -weight[k] * weight[k] / square_, s[k]);
}

Rho TukeyLoss::Evaluate(double s) const {
  if (s > square_) return {square_ / 3.0, 0.0, 0.0};
  // u = s/δ², v = 1 − u:  1 − v³ = 3u (1 − u + u²/3), which does not cancel for small s.
  const double u = s / square_, v = 1.0 - u;
  return {s * (1.0 - u + u * u / 3.0), v * v, -2.0 * v / square_};
}

Rho PseudoHuberLoss::Evaluate(double s) const {
  const double t = 1.0 + s / square_, root = std::sqrt(t);
  // √t − 1 = (t − 1)/(√t + 1) does not cancel for small s.
  return {2.0 * s / (root + 1.0), 1.0 / root, -0.5 / (square_ * root * t)};
}

Rho GemanMcClureLoss::Evaluate(double s) const {
  const double c = threshold_ / (threshold_ + s);
  return {c * s, c * c, -2.0 * c * c / (threshold_ + s)};
}

Rho WelschLoss::Evaluate(double s) const {
  const double slope = std::exp(-s / square_);
  return {-square_ * std::expm1(-s / square_), slope, -slope / square_};
}

Rho FairLoss::Evaluate(double s) const {
  const double x = std::sqrt(s) / threshold_, slope = 1.0 / (1.0 + x);
  // x − log(1 + x) = x²/2 − x³/3 + x⁴/4 − …, which cancels for small x.
  const double gap = x < 1e-3 ? x * x * (0.5 - x * (1.0 / 3.0 - x * (0.25 - 0.2 * x))) : x - std::log1p(x);
  const double curvature = s > 0.0 ? -0.5 * slope * slope / (threshold_ * std::sqrt(s)) : 0.0;
  return {2.0 * square_ * gap, slope, curvature};
}

Rho SaturatedLoss::Evaluate(double s) const {
  if (s > square_) return {square_, 0.0, 0.0};
  return {s, 1.0, 0.0};
}

Rho DcsLoss::Evaluate(double s) const {
  if (s <= threshold_) return {s, 1.0, 0.0};
  const double c = 2.0 * threshold_ / (threshold_ + s);
  return {threshold_ * (3.0 * s - threshold_) / (s + threshold_), c * c, -2.0 * c * c / (threshold_ + s)};
}

ScaleDeltaLoss::ScaleDeltaLoss(std::shared_ptr<const LossFunction> kappa, double delta)
    : LossFunction(kappa ? kappa->Correction() : LossCorrection::kTriggs),
      kappa_(std::move(kappa)),
      square_(RequirePositive(delta) * delta) {
  if (!kappa_) throw std::invalid_argument("ScaleDeltaLoss: there is no loss to scale (null)");
}

Rho ScaleDeltaLoss::Evaluate(double s) const {
  const Rho kappa = kappa_->Evaluate(s / square_);
  return {square_ * kappa[0], kappa[1], kappa[2] / square_};
}

RobustWeight CorrectLoss(const Rho& rho, double s, LossCorrection correction) {
  return {rho[1], correction == LossCorrection::kTriggs ? RankOne(rho[1], rho[2], s) : 0.0};
}

}  // namespace ch5
