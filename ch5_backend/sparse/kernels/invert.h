#pragma once
/// The inverse of a small symmetric matrix, or of eight at once, one in each lane.

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "ch5_backend/linear/pivot_rule.h"
#include "ch5_backend/sparse/kernels/blocks.h"

namespace ch5::kernels {

CH5_INLINE bool AllTrue(bool good) { return good; }
template <typename Mask>
CH5_INLINE bool AllTrue(const Mask& good) {
  bool all = true;
  for (int k = 0; k < kPack; ++k) all = all && good[k];
  return all;
}
CH5_INLINE void SquareRoot(const double& x, double* root) { *root = std::sqrt(x); }
CH5_INLINE void SquareRoot(const WideLanes& x, WideLanes* root) {
  for (int k = 0; k < kPack; ++k) (*root)[k] = std::sqrt(x[k]);
}

/// V = A⁻¹ by Cholesky, both l×l without padding; A is overwritten by its factor. T is a number, or one for each lane.
/// @return  false unless every pivot exceeds its rounding (linear/pivot_rule.h)
template <int L, typename T>
CH5_INLINE bool InvertSymmetric(T* A, int l_size, T* V) {
  const int l = Pick<L>(l_size);
  const double rounding = PivotRounding(l), most = std::numeric_limits<double>::max();
  auto good = A[0] == A[0];
  for (int j = 0; j < l; ++j) {  // A = G Gᵀ, G in the lower half
    T pivot = A[j * l + j], root;
    for (int k = 0; k < j; ++k) pivot -= A[k * l + j] * A[k * l + j];
    good = good & (pivot > rounding * A[j * l + j]) & (pivot <= most);
    SquareRoot(pivot, &root);
    root = 1.0 / root;
    for (int i = j + 1; i < l; ++i) {
      T sum = A[j * l + i];
      for (int k = 0; k < j; ++k) sum -= A[k * l + i] * A[k * l + j];
      A[j * l + i] = sum * root;
    }
    A[j * l + j] = root;  // the reciprocal of G_jj
  }
  for (int c = 0; c < l; ++c) {  // G⁻¹ in place, column by column
    for (int i = c + 1; i < l; ++i) {
      T sum = {};
      for (int k = c; k < i; ++k) sum -= A[k * l + i] * A[c * l + k];
      A[c * l + i] = sum * A[i * l + i];
    }
  }
  for (int c = 0; c < l; ++c) {  // V = G⁻ᵀG⁻¹
    for (int r = c; r < l; ++r) {
      T sum = A[r * l + r] * A[c * l + r];
      for (int k = r + 1; k < l; ++k) sum += A[r * l + k] * A[c * l + k];
      V[c * l + r] = V[r * l + c] = sum;
    }
  }
  return AllTrue(good);
}

}  // namespace ch5::kernels
