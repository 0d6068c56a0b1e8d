#pragma once
/// A block of H_pl as its two factors, where one edge alone ties a landmark to a pose:
///
///   H_pl = J̃_pᵀ J̃_l,     J̃_p 2×P,  J̃_l 2×L,  one row behind the other: [J̃_p J̃_l]_1 [J̃_p J̃_l]_2
///
/// in single precision: 96 bytes for a camera and a point, where the block has 216, and a product with it costs no more.
/// The sums in H_pp and H_ll are those of the rounded factors, so that S = H_pp − C stays positive semi-definite, which
/// blocks of H_pl that are rounded for themselves would not warrant. b is exact, so the optimum is the same.

#include "ch5_backend/linear/block_matrix.h"
#include "ch5_backend/math/dispatch.h"

namespace ch5::kernels {

/// Four single-precision numbers, as doubles.
typedef float FloatLanesInMemory __attribute__((vector_size(16), aligned(4)));
CH5_INLINE void Widen(const float* x, Lanes* out) {
  *out = __builtin_convertvector(*reinterpret_cast<const FloatLanesInMemory*>(x), Lanes);
}

template <int P, int L>
class SlotFactors {
 public:
  static constexpr int kRow = P + L, kSize = 2 * kRow;

  /// Stores the factors, and rounds the J̃ to what is stored. They have Stride(columns) numbers a row.
  static CH5_INLINE void Store(double* J_p, double* J_l, float* factors) {
    for (int r = 0; r < 2; ++r) {
      for (int k = 0; k < P; ++k) factors[r * kRow + k] = static_cast<float>(J_p[r * Stride(P) + k]);
      for (int k = 0; k < L; ++k) factors[r * kRow + P + k] = static_cast<float>(J_l[r * Stride(L) + k]);
    }
    __asm__ volatile("" ::: "memory");  // GCC 12 takes a vector to float and back for the vector itself
    for (int r = 0; r < 2; ++r) {
      for (int k = 0; k < P; ++k) J_p[r * Stride(P) + k] = factors[r * kRow + k];
      for (int k = 0; k < L; ++k) J_l[r * Stride(L) + k] = factors[r * kRow + P + k];
    }
  }

  /// w (L) += H_plᵀ x = J̃_lᵀ (J̃_p x)
  static CH5_INLINE void AddTransposed(const float* factors, const double* x, double* w) {
    Lanes sums[2] = {}, even, odd;
    double rest[2] = {};
    CH5_UNROLL
    for (int r = 0; r < 2; ++r) {
      const float* row = factors + r * kRow;
      CH5_UNROLL
      for (int k = 0; k < kWhole; ++k) {
        Lanes J;
        Widen(row + k * kLanes, &J);
        sums[r] += J * AsLanes(x)[k];
      }
      CH5_UNROLL
      for (int k = kWhole * kLanes; k < P; ++k) rest[r] += row[k] * x[k];
    }
    Shuffle<0, 4, 2, 6>(sums[0], sums[1], &even);
    Shuffle<1, 5, 3, 7>(sums[0], sums[1], &odd);
    even += odd;
    const double t[2] = {even[0] + even[2] + rest[0], even[1] + even[3] + rest[1]};  // J̃_p x
    CH5_UNROLL
    for (int m = 0; m < L; ++m) w[m] += factors[P + m] * t[0] + factors[kRow + P + m] * t[1];
  }

  /// y (P) −= H_pl v = J̃_pᵀ (J̃_l v)
  static CH5_INLINE void SubtractProduct(const float* factors, const double* v, double* y) {
    double u[2] = {};  // J̃_l v
    CH5_UNROLL
    for (int m = 0; m < L; ++m) {
      u[0] += factors[P + m] * v[m];
      u[1] += factors[kRow + P + m] * v[m];
    }
    CH5_UNROLL
    for (int k = 0; k < kWhole; ++k) {
      Lanes a, b;
      Widen(factors + k * kLanes, &a);
      Widen(factors + kRow + k * kLanes, &b);
      AsLanes(y)[k] -= a * u[0] + b * u[1];
    }
    CH5_UNROLL
    for (int k = kWhole * kLanes; k < P; ++k) y[k] -= factors[k] * u[0] + factors[kRow + k] * u[1];
  }

  /// H (P×L, column-major without padding) = J̃_pᵀ J̃_l
  static CH5_INLINE void Expand(const float* factors, double* H) {
    for (int m = 0; m < L; ++m, H += P) {
      const double a = factors[P + m], b = factors[kRow + P + m];
      for (int k = 0; k < P; ++k) H[k] = factors[k] * a + factors[kRow + k] * b;
    }
  }

 private:
  static constexpr int kWhole = P / kLanes;
};

}  // namespace ch5::kernels
