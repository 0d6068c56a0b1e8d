#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ch5_homework/judge/in_memory.h"

namespace ch5::compiled {

// Column by column of C, to which four columns of A are added at a time. C is cleared before A and B are read, as by Eigen: where
// a student's noalias() is wrong, the product is.
void Multiply(double factor, const View<const double>& A, const View<const double>& B, bool adds,
              const View<double>& C) {
  const std::ptrdiff_t rows = A.rows, inner = A.columns;
  for (std::ptrdiff_t j = 0; !adds && j < B.columns; ++j) {
    for (std::ptrdiff_t i = 0; i < rows; ++i) C(i, j) = 0.0;
  }
  std::vector<double> columns(static_cast<size_t>(rows * inner)), sum(static_cast<size_t>(rows));
  const View<double> packed{columns.data(), rows, inner, 1, rows};
  for (std::ptrdiff_t k = 0; k < inner; ++k) {
    for (std::ptrdiff_t i = 0; i < rows; ++i) packed(i, k) = A(i, k);
  }
  double* const __restrict c = sum.data();
  for (std::ptrdiff_t j = 0; j < B.columns; ++j) {
    std::fill(sum.begin(), sum.end(), 0.0);
    std::ptrdiff_t k = 0;
    for (; k + 4 <= inner; k += 4) {
      const double* const a = &packed(0, k);
      const double b_0 = B(k, j), b_1 = B(k + 1, j), b_2 = B(k + 2, j), b_3 = B(k + 3, j);
      for (std::ptrdiff_t i = 0; i < rows; ++i) {
        c[i] += a[i] * b_0 + a[i + rows] * b_1 + a[i + 2 * rows] * b_2 + a[i + 3 * rows] * b_3;
      }
    }
    for (; k < inner; ++k) {
      const double* const a = &packed(0, k);
      const double b = B(k, j);
      for (std::ptrdiff_t i = 0; i < rows; ++i) c[i] += a[i] * b;
    }
    for (std::ptrdiff_t i = 0; i < rows; ++i) C(i, j) += factor * c[i];
  }
}

// The row from k on whose entry of column k is the largest.
static std::ptrdiff_t PivotOf(const View<double>& A, std::ptrdiff_t k) {
  std::ptrdiff_t pivot = k;
  for (std::ptrdiff_t i = k; i < A.rows; ++i) {
    if (std::abs(A(i, k)) > std::abs(A(pivot, k))) pivot = i;
  }
  return pivot;
}

static void ExchangeRows(const View<double>& A, std::ptrdiff_t k, std::ptrdiff_t l) {
  for (std::ptrdiff_t j = 0; j < A.columns; ++j) std::swap(A(k, j), A(l, j));
}

void Invert(const View<double>& A, const View<double>& inverse) {
  const std::ptrdiff_t n = A.rows;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    for (std::ptrdiff_t j = 0; j < n; ++j) inverse(i, j) = i == j ? 1.0 : 0.0;
  }
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    const std::ptrdiff_t pivot = PivotOf(A, k);
    for (const View<double>& M : {A, inverse}) ExchangeRows(M, k, pivot);
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      const double times = A(i, k) / A(k, k);
      for (const View<double>& M : {A, inverse}) {
        for (std::ptrdiff_t j = 0; j < n; ++j) M(i, j) = i == k ? M(k, j) : M(i, j) - times * M(k, j);
      }
    }
  }
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    for (std::ptrdiff_t j = 0; j < n; ++j) inverse(i, j) /= A(i, i);
  }
}

void Tridiagonalize(const View<double>& A, double* diagonal, double* beside) {
  const std::ptrdiff_t n = A.rows;
  // Column k: v of the reflection I − β v vᵀ, which makes zeros of column k of A, below the entry that is left beside the diagonal.
  std::vector<double> numbers(static_cast<size_t>(n * n)), beta(static_cast<size_t>(n)), w(static_cast<size_t>(n));
  const View<double> V{numbers.data(), n, n, 1, n};
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    diagonal[k] = A(k, k);
    double below = 0.0;  // of the squares
    for (std::ptrdiff_t i = k + 2; i < n; ++i) below += A(i, k) * A(i, k);
    if (k + 1 < n) beside[k] = A(k + 1, k);
    if (below == 0.0) continue;
    beside[k] = std::copysign(std::sqrt(A(k + 1, k) * A(k + 1, k) + below), -A(k + 1, k));
    for (std::ptrdiff_t i = k + 1; i < n; ++i) V(i, k) = A(i, k);
    V(k + 1, k) -= beside[k];
    beta[k] = 2.0 / (V(k + 1, k) * V(k + 1, k) + below);
    // A − v wᵀ − w vᵀ,  w = β A v − ½ β² (vᵀ A v) v
    double vw = 0.0;
    for (std::ptrdiff_t i = k + 1; i < n; ++i) {
      w[i] = 0.0;
      for (std::ptrdiff_t j = k + 1; j < n; ++j) w[i] += beta[k] * A(std::max(i, j), std::min(i, j)) * V(j, k);
      vw += w[i] * V(i, k);
    }
    for (std::ptrdiff_t i = k + 1; i < n; ++i) w[i] -= 0.5 * beta[k] * vw * V(i, k);
    for (std::ptrdiff_t j = k + 1; j < n; ++j) {
      for (std::ptrdiff_t i = j; i < n; ++i) A(i, j) -= V(i, k) * w[j] + w[i] * V(j, k);
    }
  }
  for (std::ptrdiff_t j = 0; j < n; ++j) {
    for (std::ptrdiff_t i = 0; i < n; ++i) A(i, j) = i == j ? 1.0 : 0.0;
    for (std::ptrdiff_t k = n - 1; k >= 0; --k) {
      double product = 0.0;
      for (std::ptrdiff_t i = k + 1; i < n; ++i) product += V(i, k) * A(i, j);
      for (std::ptrdiff_t i = k + 1; i < n; ++i) A(i, j) -= beta[k] * product * V(i, k);
    }
  }
}

void Reflect(const View<double>& A, const View<const double>& V, const double* h, bool last_first) {
  for (std::ptrdiff_t n = 0; n < V.columns; ++n) {
    const std::ptrdiff_t k = last_first ? V.columns - 1 - n : n;
    for (std::ptrdiff_t j = 0; j < A.columns; ++j) {
      double product = A(k, j);
      for (std::ptrdiff_t i = k + 1; i < A.rows; ++i) product += V(i, k) * A(i, j);
      A(k, j) -= h[k] * product;
      for (std::ptrdiff_t i = k + 1; i < A.rows; ++i) A(i, j) -= h[k] * product * V(i, k);
    }
  }
}

int Factor(const View<double>& A, int* pivots) {
  int transpositions = 0;
  for (std::ptrdiff_t k = 0; k < A.rows; ++k) {
    const std::ptrdiff_t pivot = PivotOf(A, k);
    pivots[k] = static_cast<int>(pivot);
    transpositions += pivot != k;
    ExchangeRows(A, k, pivot);
    for (std::ptrdiff_t i = k + 1; i < A.rows && A(k, k) != 0.0; ++i) {
      A(i, k) /= A(k, k);
      for (std::ptrdiff_t j = k + 1; j < A.columns; ++j) A(i, j) -= A(i, k) * A(k, j);
    }
  }
  return transpositions;
}

}  // namespace ch5::compiled
