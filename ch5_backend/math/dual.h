#pragma once
/// Numbers that carry their derivatives by N unknowns: a formula written for any number type then gives its Jacobian, exact
/// to rounding, by the chain rule (forward automatic differentiation; Griewank & Walther, "Evaluating Derivatives", §3.1).

#include <cmath>

#include "ch5_backend/math/eigen_types.h"
#include "ch5_backend/math/simd.h"

namespace ch5 {

/// ∂f/∂x by N unknowns, in whole registers: at plain -O2 a compiler would take small matrices number by number.
template <int N>
struct Gradient {
  static constexpr size_t kParts = static_cast<size_t>(Padded(N)) / kLanes;
  LanesInMemory part[kParts];

  CH5_INLINE double operator[](int k) const { return part[k / kLanes][k % kLanes]; }

  /// a f' + b g', the chain rule.
  CH5_INLINE friend Gradient Combined(double a, const Gradient& f, double b, const Gradient& g) {
    Gradient sum;
    CH5_UNROLL
    for (size_t i = 0; i < kParts; ++i) sum.part[i] = a * f.part[i] + b * g.part[i];
    return sum;
  }
  CH5_INLINE friend Gradient operator*(double a, const Gradient& f) {
    Gradient scaled;
    CH5_UNROLL
    for (size_t i = 0; i < kParts; ++i) scaled.part[i] = a * f.part[i];
    return scaled;
  }
};

/// f and ∂f/∂x, 1×N.
template <int N>
struct Dual {
  double value = 0.0;
  ch5::Gradient<N> gradient{};

  CH5_INLINE Dual() = default;
  CH5_INLINE Dual(double constant) : value(constant) {}  // NOLINT: a number is a constant
  CH5_INLINE Dual(double f, const ch5::Gradient<N>& df) : value(f), gradient(df) {}
  /// The unknown x_k at x.
  CH5_INLINE static Dual Unknown(double x, int k) {
    Dual unknown(x);
    unknown.gradient.part[k / kLanes][k % kLanes] = 1.0;
    return unknown;
  }

  CH5_INLINE Dual& operator+=(const Dual& g) { return *this = *this + g; }
  CH5_INLINE Dual& operator-=(const Dual& g) { return *this = *this - g; }
  CH5_INLINE Dual& operator*=(const Dual& g) { return *this = *this * g; }
  CH5_INLINE Dual& operator/=(const Dual& g) { return *this = *this / g; }

  // Friends, so that a number on either side becomes a constant.
  CH5_INLINE friend Dual operator-(const Dual& f) { return {-f.value, -1.0 * f.gradient}; }
  CH5_INLINE friend Dual operator+(const Dual& f, const Dual& g) {
    return {f.value + g.value, Combined(1.0, f.gradient, 1.0, g.gradient)};
  }
  CH5_INLINE friend Dual operator-(const Dual& f, const Dual& g) {
    return {f.value - g.value, Combined(1.0, f.gradient, -1.0, g.gradient)};
  }
  CH5_INLINE friend Dual operator*(const Dual& f, const Dual& g) {
    return {f.value * g.value, Combined(g.value, f.gradient, f.value, g.gradient)};
  }
  CH5_INLINE friend Dual operator/(const Dual& f, const Dual& g) {
    const double inverse = 1.0 / g.value, quotient = f.value / g.value;
    return {quotient, Combined(inverse, f.gradient, -quotient * inverse, g.gradient)};
  }
  // And a constant without its zeros.
  CH5_INLINE friend Dual operator+(const Dual& f, double c) { return {f.value + c, f.gradient}; }
  CH5_INLINE friend Dual operator+(double c, const Dual& f) { return {c + f.value, f.gradient}; }
  CH5_INLINE friend Dual operator-(const Dual& f, double c) { return {f.value - c, f.gradient}; }
  CH5_INLINE friend Dual operator-(double c, const Dual& f) { return {c - f.value, -1.0 * f.gradient}; }
  CH5_INLINE friend Dual operator*(const Dual& f, double c) { return {f.value * c, c * f.gradient}; }
  CH5_INLINE friend Dual operator*(double c, const Dual& f) { return {c * f.value, c * f.gradient}; }
  CH5_INLINE friend Dual operator/(const Dual& f, double c) { return {f.value / c, (1.0 / c) * f.gradient}; }
  CH5_INLINE friend bool operator==(const Dual& f, const Dual& g) { return f.value == g.value; }
  CH5_INLINE friend bool operator!=(const Dual& f, const Dual& g) { return f.value != g.value; }
  CH5_INLINE friend bool operator<(const Dual& f, const Dual& g) { return f.value < g.value; }
  CH5_INLINE friend bool operator>(const Dual& f, const Dual& g) { return f.value > g.value; }
  CH5_INLINE friend bool operator<=(const Dual& f, const Dual& g) { return f.value <= g.value; }
  CH5_INLINE friend bool operator>=(const Dual& f, const Dual& g) { return f.value >= g.value; }

  // NOLINTBEGIN(readability-identifier-naming): std's and Eigen's names
  // (φ∘f)' = φ'(f) f'; found by name, as std's are for numbers: using std::sqrt; sqrt(x).
  CH5_INLINE friend Dual sqrt(const Dual& f) {
    const double root = std::sqrt(f.value);
    return {root, (0.5 / root) * f.gradient};
  }
  CH5_INLINE friend Dual exp(const Dual& f) { return {std::exp(f.value), std::exp(f.value) * f.gradient}; }
  CH5_INLINE friend Dual log(const Dual& f) { return {std::log(f.value), (1.0 / f.value) * f.gradient}; }
  CH5_INLINE friend Dual sin(const Dual& f) { return {std::sin(f.value), std::cos(f.value) * f.gradient}; }
  CH5_INLINE friend Dual cos(const Dual& f) { return {std::cos(f.value), -std::sin(f.value) * f.gradient}; }
  CH5_INLINE friend Dual tan(const Dual& f) {
    const double tangent = std::tan(f.value);
    return {tangent, (1.0 + tangent * tangent) * f.gradient};
  }
  CH5_INLINE friend Dual asin(const Dual& f) {
    return {std::asin(f.value), (1.0 / std::sqrt(1.0 - f.value * f.value)) * f.gradient};
  }
  CH5_INLINE friend Dual acos(const Dual& f) {
    return {std::acos(f.value), (-1.0 / std::sqrt(1.0 - f.value * f.value)) * f.gradient};
  }
  CH5_INLINE friend Dual atan(const Dual& f) {
    return {std::atan(f.value), (1.0 / (1.0 + f.value * f.value)) * f.gradient};
  }
  CH5_INLINE friend Dual tanh(const Dual& f) {
    const double tangent = std::tanh(f.value);
    return {tangent, (1.0 - tangent * tangent) * f.gradient};
  }
  CH5_INLINE friend Dual pow(const Dual& f, double exponent) {
    return {std::pow(f.value, exponent), exponent * std::pow(f.value, exponent - 1.0) * f.gradient};
  }
  CH5_INLINE friend Dual hypot(const Dual& f, const Dual& g) {
    const double root = std::hypot(f.value, g.value);
    return {root, Combined(f.value / root, f.gradient, g.value / root, g.gradient)};
  }
  CH5_INLINE friend Dual atan2(const Dual& y, const Dual& x) {
    const double squared = x.value * x.value + y.value * y.value;
    return {std::atan2(y.value, x.value), Combined(x.value / squared, y.gradient, -y.value / squared, x.gradient)};
  }
  CH5_INLINE friend Dual abs(const Dual& f) { return f.value < 0.0 ? -f : f; }
  CH5_INLINE friend Dual fabs(const Dual& f) { return abs(f); }
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
