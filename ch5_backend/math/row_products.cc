#include "ch5_backend/math/row_products.h"

#include <algorithm>

#include "ch5_backend/math/dispatch.h"

namespace ch5::kernels {
namespace {

constexpr int kMost = 4;  // registers of a sum at once

// out = Σ_k f[k·step] Y_k over N registers of each row; of C, which is negative, zeros are skipped.
template <int N, bool kOfC, typename Vector>
CH5_INLINE void SumRows(int rows, const double* f, int step, const double* Y, int stride, double* out) {
  constexpr int kWidth = sizeof(Vector) / sizeof(double);
  Vector sum[N] = {}, row;
  for (int k = 0; k < rows; ++k, f += step, Y += stride) {
    if (kOfC && *f == 0.0) continue;
    CH5_UNROLL
    for (int g = 0; g < N; ++g) {
      Load(Y + g * kWidth, &row);
      sum[g] += *f * row;
    }
  }
  CH5_UNROLL
  for (int g = 0; g < N; ++g) Store(kOfC ? -sum[g] : sum[g], out + g * kWidth);
}

// The same over so many registers.
template <bool kOfC, typename Vector>
CH5_INLINE void SumRows(int registers, int rows, const double* f, int step, const double* Y, int stride, double* out) {
  constexpr int kStep = kMost * sizeof(Vector) / sizeof(double);
  for (; registers > kMost; registers -= kMost, Y += kStep, out += kStep) {
    SumRows<kMost, kOfC, Vector>(rows, f, step, Y, stride, out);
  }
  switch (registers) {
    case 1: return SumRows<1, kOfC, Vector>(rows, f, step, Y, stride, out);
    case 2: return SumRows<2, kOfC, Vector>(rows, f, step, Y, stride, out);
    case 3: return SumRows<3, kOfC, Vector>(rows, f, step, Y, stride, out);
    default: return SumRows<kMost, kOfC, Vector>(rows, f, step, Y, stride, out);
  }
}

struct RowsTimes {
  using Signature = void(int rows, int columns, const double* M, const double* X, double* Y);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int rows, int columns, const double* M, const double* X, double* Y) {
    using Vector = FittingLanes<kSimd>;
    const int stride = RowStride(columns), registers = stride / static_cast<int>(sizeof(Vector) / sizeof(double));
    for (int i = 0; i < rows; ++i) SumRows<false, Vector>(registers, rows, M + i * rows, 1, X, stride, Y + i * stride);
  }
};

// Column c of C is a sum of Y's rows, from the register with number c on. What is written behind its end belongs to the
// next column, which comes later; behind C's own end nothing is written.
struct NegativeGram {
  using Signature = void(int rows, int columns, const double* X, const double* Y, double* C);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int rows, int columns, const double* X, const double* Y, double* C) {
    using Vector = FittingLanes<kSimd>;
    constexpr int kWidth = sizeof(Vector) / sizeof(double);
    const int stride = RowStride(columns), last = columns / kWidth * kWidth;
    const double* const end = C + columns * columns;
    for (int c = 0; c < columns; ++c, C += columns) {
      const int first = c / kWidth * kWidth, registers = (stride - first) / kWidth;
      const bool has_room = C + stride <= end;
      if (has_room || first < last) {
        SumRows<true, Vector>(has_room ? registers : (last - first) / kWidth, rows, X + c, stride, Y + first, stride,
                              C + first);
      }
      if (has_room || last == columns) continue;
      double rest[kWidth];
      SumRows<1, true, Vector>(rows, X + c, stride, Y + last, stride, rest);
      std::copy_n(rest, columns - last, C + last);
    }
  }
};

}  // namespace

void MultiplyRows(int rows, int columns, const double* M, const double* X, double* Y) {
  Dispatch<RowsTimes>()(rows, columns, M, X, Y);
}

void NegativeProducts(int rows, int columns, const double* X, const double* Y, double* C) {
  Dispatch<NegativeGram>()(rows, columns, X, Y, C);
}

}  // namespace ch5::kernels
