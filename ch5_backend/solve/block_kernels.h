#pragma once
/// The inner loops of the fast room, on raw blocks. Sizes known at compile time unroll and vectorise; Dynamic ones
/// are read at run time. Every block has Stride(rows) numbers a column (see block_matrix.h), Jacobians Stride(columns)
/// numbers a row.

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "ch5_backend/solve/block_matrix.h"

namespace ch5::kernels {

/// A size that is a constant where it is known at compile time.
template <int N>
constexpr int Pick(int size) {
  return N == Eigen::Dynamic ? size : N;
}

/// C (p×q) += AᵀB;  A is rows×p, B rows×q.
template <int P, int Q>
inline void AddTransposeProduct(const double* A, const double* B, int rows, int p_size, int q_size,
                                double* __restrict C) {
  const int p = Stride(Pick<P>(p_size)), q = Pick<Q>(q_size), B_stride = Stride(q);
  for (int r = 0; r < rows; ++r, A += p, B += B_stride) {
    for (int c = 0; c < q; ++c) {
      for (int k = 0; k < p; ++k) C[c * p + k] += A[k] * B[c];
    }
  }
}

/// y (p) += sign · Aᵀr;  A is rows×p.
template <int P>
inline void AddTransposeVector(const double* A, const double* r, int rows, int p_size, double sign,
                               double* __restrict y) {
  const int p = Pick<P>(p_size);
  for (int k = 0; k < rows; ++k, A += Stride(p)) {
    for (int i = 0; i < p; ++i) y[i] += sign * r[k] * A[i];
  }
}

/// C (p×q) −= A Bᵀ;  A is p×l, B is q×l.
template <int P, int Q, int L>
inline void SubtractProduct(const double* A, const double* B, int p_size, int q_size, int l_size,
                            double* __restrict C) {
  const int p = Stride(Pick<P>(p_size)), q = Pick<Q>(q_size), B_stride = Stride(q), l = Pick<L>(l_size);
  for (int c = 0; c < q; ++c, C += p) {
    for (int m = 0; m < l; ++m) {
      const double b = B[m * B_stride + c];
      for (int k = 0; k < p; ++k) C[k] -= A[m * p + k] * b;
    }
  }
}

/// Y (p×l) = W V;  W is p×l, V l×l without padding, symmetric.
template <int P, int L>
inline void Multiply(const double* W, const double* V, int p_size, int l_size, double* __restrict Y) {
  const int p = Stride(Pick<P>(p_size)), l = Pick<L>(l_size);
  for (int c = 0; c < l; ++c) {
    for (int k = 0; k < p; ++k) Y[c * p + k] = W[k] * V[c * l];
    for (int m = 1; m < l; ++m) {
      for (int k = 0; k < p; ++k) Y[c * p + k] += W[m * p + k] * V[c * l + m];
    }
  }
}

/// y (p) += sign · W x;  W is p×l.
template <int P, int L>
inline void AddProduct(const double* W, const double* x, int p_size, int l_size, double sign, double* __restrict y) {
  const int p = Pick<P>(p_size), l = Pick<L>(l_size);
  for (int m = 0; m < l; ++m) {
    for (int k = 0; k < p; ++k) y[k] += sign * W[m * Stride(p) + k] * x[m];
  }
}

/// y (l) += sign · Wᵀx;  W is p×l.
template <int P, int L>
inline void AddTransposed(const double* W, const double* x, int p_size, int l_size, double sign, double* __restrict y) {
  const int p = Pick<P>(p_size), l = Pick<L>(l_size);
  for (int m = 0; m < l; ++m) {
    double sum = 0.0;
    for (int k = 0; k < p; ++k) sum += W[m * Stride(p) + k] * x[k];
    y[m] += sign * sum;
  }
}

/// y (l) += V x;  V is l×l without padding, symmetric.
template <int L>
inline void AddSymmetric(const double* V, const double* x, int l_size, double* __restrict y) {
  const int l = Pick<L>(l_size);
  for (int c = 0; c < l; ++c) {
    for (int k = 0; k < l; ++k) y[k] += V[c * l + k] * x[c];
  }
}

/// V = A⁻¹ by Cholesky, both l×l without padding; A is overwritten by its factor.
/// @return false unless every pivot exceeds 8·l·ε of its diagonal entry, whatever the units: below is rounding
template <int L>
inline bool InvertSymmetric(double* A, int l_size, double* __restrict V) {
  const int l = Pick<L>(l_size);
  const double rounding = 8.0 * l * std::numeric_limits<double>::epsilon();
  for (int j = 0; j < l; ++j) {  // A = G Gᵀ, G in the lower half
    double pivot = A[j * l + j];
    for (int k = 0; k < j; ++k) pivot -= A[k * l + j] * A[k * l + j];
    if (!(pivot > rounding * A[j * l + j]) || !std::isfinite(pivot)) return false;
    const double root = 1.0 / std::sqrt(pivot);
    for (int i = j + 1; i < l; ++i) {
      double sum = A[j * l + i];
      for (int k = 0; k < j; ++k) sum -= A[k * l + i] * A[k * l + j];
      A[j * l + i] = sum * root;
    }
    A[j * l + j] = root;  // the reciprocal of G_jj
  }
  for (int c = 0; c < l; ++c) {  // G⁻¹ in place, column by column
    for (int i = c + 1; i < l; ++i) {
      double sum = 0.0;
      for (int k = c; k < i; ++k) sum -= A[k * l + i] * A[c * l + k];
      A[c * l + i] = sum * A[i * l + i];
    }
  }
  for (int c = 0; c < l; ++c) {  // V = G⁻ᵀG⁻¹
    for (int r = c; r < l; ++r) {
      double sum = 0.0;
      for (int k = r; k < l; ++k) sum += A[r * l + k] * A[c * l + k];
      V[c * l + r] = V[r * l + c] = sum;
    }
  }
  return true;
}

}  // namespace ch5::kernels
