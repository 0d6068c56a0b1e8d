#pragma once
/// The χ² distribution of a whole number of degrees of freedom.

#include <cmath>

namespace ch5 {

/// P(χ²_n > x):  Q_1 = erfc √(x/2),  Q_2 = e^(−x/2),  Q_{n+2} = Q_n + (x/2)^(n/2) e^(−x/2) / Γ(n/2 + 1).
/// @param n  degrees of freedom, at least 1;  @param x  ≥ 0
inline double ChiSquaredTail(int n, double x) {
  double tail = n % 2 == 1 ? std::erfc(std::sqrt(0.5 * x)) : std::exp(-0.5 * x);
  for (double k = n % 2 == 1 ? 0.5 : 1.0; k < 0.5 * n; k += 1.0)
    tail += std::exp(k * std::log(0.5 * x) - 0.5 * x - std::lgamma(k + 1.0));
  return tail;
}

/// The x with P(χ²_n > x) = tail, by bisection.
/// @param tail  in (0, 1)
inline double ChiSquaredLimit(int n, double tail) {
  double low = 0.0, high = 1.0;
  while (ChiSquaredTail(n, high) > tail) high *= 2.0;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (ChiSquaredTail(n, middle) > tail ? low : high) = middle;
  }
  return high;
}

}  // namespace ch5
