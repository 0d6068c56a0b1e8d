#pragma once
/// Random numbers that are the same to the bit with every compiler and standard library.
///
/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), 53-bit uniforms, normals by Marsaglia's polar method. The standard's
/// distributions are unspecified and differ between libraries; these are specified here, line by line.

#include <cmath>
#include <cstdint>

#include "ch5_backend/math/eigen_types.h"

namespace ch5 {

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t Bits() {
    state_ += 0x9E3779B97F4A7C15u;
    uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }

  /// Uniform on [0, 1), a multiple of 2⁻⁵³.
  double Uniform() { return static_cast<double>(Bits() >> 11) * 0x1p-53; }
  /// Uniform on [low, high).
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }

  /// Normal with mean 0 and standard deviation 1; each call draws afresh and uses one of the polar pair.
  double Normal() {
    for (;;) {
      const double x = Uniform(-1.0, 1.0);
      const double y = Uniform(-1.0, 1.0);
      const double s = x * x + y * y;
      if (s > 0.0 && s < 1.0) return x * std::sqrt(-2.0 * std::log(s) / s);
    }
  }
  /// Normal within ±`bound` standard deviations, by rejection.
  double TruncatedNormal(double bound) {
    for (;;) {
      const double x = Normal();
      if (std::abs(x) <= bound) return x;
    }
  }

 private:
  uint64_t state_;
};

/// N independent normals of deviation `sigma`: x, then y, then z. (As arguments of a constructor they would be drawn in an
/// order that C++ leaves open.)
template <int N = 3>
Eigen::Matrix<double, N, 1> NormalVector(Random* random, double sigma) {
  Eigen::Matrix<double, N, 1> x;
  for (int i = 0; i < N; ++i) x[i] = sigma * random->Normal();
  return x;
}

/// A point of the box between two corners, each coordinate uniform: x, then y, then z.
inline Vec3 UniformVector(Random* random, const Vec3& low, const Vec3& high) {
  const double x = random->Uniform(low.x(), high.x());
  const double y = random->Uniform(low.y(), high.y());
  const double z = random->Uniform(low.z(), high.z());
  return {x, y, z};
}

}  // namespace ch5
