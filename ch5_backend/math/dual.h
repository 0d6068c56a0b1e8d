#pragma once
/// Numbers that carry their derivatives by N unknowns: a formula written for any number type then gives its Jacobian, exact
/// to rounding, by the chain rule (forward automatic differentiation; Griewank & Walther, "Evaluating Derivatives", §3.1).

#include <Eigen/Core>
#include <cmath>

namespace ch5 {

/// f and ∂f/∂x, 1×N.
template <int N>
struct Dual {
  using Gradient = Eigen::Matrix<double, 1, N>;

  double value = 0.0;
  Gradient gradient = Gradient::Zero();

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT: a number is a constant
  Dual(double f, const Gradient& df) : value(f), gradient(df) {}
  /// The unknown x_k at x.
  static Dual Unknown(double x, int k) { return {x, Gradient::Unit(k)}; }

  Dual& operator+=(const Dual& g) { return *this = *this + g; }
  Dual& operator-=(const Dual& g) { return *this = *this - g; }
  Dual& operator*=(const Dual& g) { return *this = *this * g; }
  Dual& operator/=(const Dual& g) { return *this = *this / g; }

  // Friends, so that a number on either side becomes a constant.
  friend Dual operator-(const Dual& f) { return {-f.value, -f.gradient}; }
  friend Dual operator+(const Dual& f, const Dual& g) { return {f.value + g.value, f.gradient + g.gradient}; }
  friend Dual operator-(const Dual& f, const Dual& g) { return {f.value - g.value, f.gradient - g.gradient}; }
  friend Dual operator*(const Dual& f, const Dual& g) {
    return {f.value * g.value, f.gradient * g.value + f.value * g.gradient};
  }
  friend Dual operator/(const Dual& f, const Dual& g) {
    const double quotient = f.value / g.value;
    return {quotient, (f.gradient - quotient * g.gradient) / g.value};
  }
  friend bool operator==(const Dual& f, const Dual& g) { return f.value == g.value; }
  friend bool operator!=(const Dual& f, const Dual& g) { return f.value != g.value; }
  friend bool operator<(const Dual& f, const Dual& g) { return f.value < g.value; }
  friend bool operator>(const Dual& f, const Dual& g) { return f.value > g.value; }
  friend bool operator<=(const Dual& f, const Dual& g) { return f.value <= g.value; }
  friend bool operator>=(const Dual& f, const Dual& g) { return f.value >= g.value; }

  // NOLINTBEGIN(readability-identifier-naming): std's and Eigen's names
  // (φ∘f)' = φ'(f) f'; found by name, as std's are for numbers: using std::sqrt; sqrt(x).
  friend Dual sqrt(const Dual& f) {
    const double root = std::sqrt(f.value);
    return {root, f.gradient / (2.0 * root)};
  }
  friend Dual exp(const Dual& f) { return {std::exp(f.value), std::exp(f.value) * f.gradient}; }
  friend Dual log(const Dual& f) { return {std::log(f.value), f.gradient / f.value}; }
  friend Dual sin(const Dual& f) { return {std::sin(f.value), std::cos(f.value) * f.gradient}; }
  friend Dual cos(const Dual& f) { return {std::cos(f.value), -std::sin(f.value) * f.gradient}; }
  friend Dual tan(const Dual& f) {
    const double tangent = std::tan(f.value);
    return {tangent, (1.0 + tangent * tangent) * f.gradient};
  }
  friend Dual asin(const Dual& f) { return {std::asin(f.value), f.gradient / std::sqrt(1.0 - f.value * f.value)}; }
  friend Dual acos(const Dual& f) { return {std::acos(f.value), -f.gradient / std::sqrt(1.0 - f.value * f.value)}; }
  friend Dual atan(const Dual& f) { return {std::atan(f.value), f.gradient / (1.0 + f.value * f.value)}; }
  friend Dual tanh(const Dual& f) {
    const double tangent = std::tanh(f.value);
    return {tangent, (1.0 - tangent * tangent) * f.gradient};
  }
  friend Dual pow(const Dual& f, double exponent) {
    return {std::pow(f.value, exponent), exponent * std::pow(f.value, exponent - 1.0) * f.gradient};
  }
  friend Dual hypot(const Dual& f, const Dual& g) {
    const double root = std::hypot(f.value, g.value);
    return {root, (f.value * f.gradient + g.value * g.gradient) / root};
  }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double squared = x.value * x.value + y.value * y.value;
    return {std::atan2(y.value, x.value), (x.value * y.gradient - y.value * x.gradient) / squared};
  }
  friend Dual abs(const Dual& f) { return f.value < 0.0 ? -f : f; }
  friend Dual fabs(const Dual& f) { return abs(f); }
};

}  // namespace ch5

namespace Eigen {

/// So that Eigen's matrices hold duals.
template <int N>
struct NumTraits<ch5::Dual<N>> : NumTraits<double> {
  using Real = ch5::Dual<N>;
  using NonInteger = ch5::Dual<N>;
  using Nested = ch5::Dual<N>;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 1,
    AddCost = 3,
    MulCost = 3
  };
};
// NOLINTEND(readability-identifier-naming)

/// And a matrix of duals be multiplied by one of numbers.
template <int N, typename Operation>
struct ScalarBinaryOpTraits<ch5::Dual<N>, double, Operation> {
  using ReturnType = ch5::Dual<N>;
};
template <int N, typename Operation>
struct ScalarBinaryOpTraits<double, ch5::Dual<N>, Operation> {
  using ReturnType = ch5::Dual<N>;
};

}  // namespace Eigen
