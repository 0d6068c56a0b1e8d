#pragma once
/// Functions of time with their first two derivatives: a curve is written once, as a formula, and its velocity and
/// acceleration follow exactly, by the chain rule (Taylor arithmetic; Griewank & Walther, "Evaluating Derivatives").

#include <cmath>

namespace ch5 {

/// f(t), ḟ(t), f̈(t).
struct Jet {
  double value = 0.0, rate = 0.0, second = 0.0;

  Jet() = default;
  Jet(double constant) : value(constant) {}  // NOLINT: a number is a constant function
  Jet(double f, double df, double ddf) : value(f), rate(df), second(ddf) {}
  /// The function t itself, at t = `time`.
  static Jet Time(double time) { return {time, 1.0, 0.0}; }
};

/// Sums and products of two functions.
inline Jet operator+(const Jet& f, const Jet& g) { return {f.value + g.value, f.rate + g.rate, f.second + g.second}; }
inline Jet operator-(const Jet& f, const Jet& g) { return {f.value - g.value, f.rate - g.rate, f.second - g.second}; }
inline Jet operator*(const Jet& f, const Jet& g) {
  return {f.value * g.value, f.rate * g.value + f.value * g.rate,
          f.second * g.value + 2.0 * f.rate * g.rate + f.value * g.second};
}

/// (φ∘f)' = φ'(f) ḟ,  (φ∘f)'' = φ''(f) ḟ² + φ'(f) f̈
inline Jet Compose(double phi, double dphi, double ddphi, const Jet& f) {
  return {phi, dphi * f.rate, ddphi * f.rate * f.rate + dphi * f.second};
}
/// sin f(t) and cos f(t).
inline Jet Sin(const Jet& f) {
  const double s = std::sin(f.value), c = std::cos(f.value);
  return Compose(s, c, -s, f);
}
inline Jet Cos(const Jet& f) {
  const double s = std::sin(f.value), c = std::cos(f.value);
  return Compose(c, -s, -c, f);
}

}  // namespace ch5
