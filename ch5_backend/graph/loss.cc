#include "ch5_backend/graph/loss.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace ch5 {
namespace {

double RequirePositive(double delta, const char* name) {
  if (!(delta > 0.0) || !std::isfinite(delta)) {
    throw std::invalid_argument(std::string(name) + ": the threshold must be positive and finite, got " +
                                std::to_string(delta));
  }
  return delta;
}

double Square(double x) { return x * x; }

}  // namespace

HuberLoss::HuberLoss(double delta, LossCorrection correction)
    : LossFunction(correction), delta_(RequirePositive(delta, "HuberLoss")) {}

Rho HuberLoss::Evaluate(double s) const {
  if (s <= delta_ * delta_) return {s, 1.0, 0.0};
  const double root = std::sqrt(s);
  const double slope = delta_ / root;
  return {2.0 * delta_ * root - delta_ * delta_, slope, -0.5 * slope / s};
}

CauchyLoss::CauchyLoss(double delta, LossCorrection correction)
    : LossFunction(correction), square_(Square(RequirePositive(delta, "CauchyLoss"))) {}

Rho CauchyLoss::Evaluate(double s) const {
  const double slope = 1.0 / (1.0 + s / square_);
  return {square_ * std::log1p(s / square_), slope, -slope * slope / square_};
}

TukeyLoss::TukeyLoss(double delta, LossCorrection correction)
    : LossFunction(correction), square_(Square(RequirePositive(delta, "TukeyLoss"))) {}

Rho TukeyLoss::Evaluate(double s) const {
  if (s > square_) return {square_ / 3.0, 0.0, 0.0};
  // u = s/δ², v = 1 − u:  1 − v³ = 3u (1 − u + u²/3), which does not cancel for small s.
  const double u = s / square_, v = 1.0 - u;
  return {s * (1.0 - u + u * u / 3.0), v * v, -2.0 * v / square_};
}

RobustWeight CorrectLoss(const Rho& rho, double s, LossCorrection correction) {
  // Huber's ρ' + 2ρ''s is zero; the margin keeps its rounding from switching the term on and off.
  constexpr double kMargin = 1e-12;
  const bool keeps_positive = rho[1] + 2.0 * rho[2] * s > kMargin * rho[1];
  const bool second_order = correction == LossCorrection::kTriggs && keeps_positive;
  return {rho[1], second_order ? 2.0 * rho[2] : 0.0};
}

}  // namespace ch5
