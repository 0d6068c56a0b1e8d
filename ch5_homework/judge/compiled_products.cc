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

void Invert(const View<double>& A, const View<double>& inverse) {
  const std::ptrdiff_t n = A.rows;
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    for (std::ptrdiff_t j = 0; j < n; ++j) inverse(i, j) = i == j ? 1.0 : 0.0;
  }
  for (std::ptrdiff_t k = 0; k < n; ++k) {
    std::ptrdiff_t pivot = k;
    for (std::ptrdiff_t i = k; i < n; ++i) {
      if (std::abs(A(i, k)) > std::abs(A(pivot, k))) pivot = i;
    }
    for (const View<double>& M : {A, inverse}) {
      for (std::ptrdiff_t j = 0; j < n; ++j) std::swap(M(k, j), M(pivot, j));
    }
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

}  // namespace ch5::compiled
