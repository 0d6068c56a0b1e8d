#include "ch5_backend/math/vector_kernels.h"

#include <type_traits>

#include "ch5_backend/math/dispatch.h"

namespace ch5::kernels {
namespace {

constexpr int kStrip = 4;  // columns at a time

// y −= A x for N columns: in whole registers, then in shorter ones.
template <int Width, int N>
CH5_INLINE void SubtractColumns(int m, const double* A, ptrdiff_t lda, const double* x, double* y) {
  using V = typename Register<Width>::Type;
  int i = 0;
  for (; i + Width <= m; i += Width) {
    V sum = *reinterpret_cast<const V*>(A + i) * x[0];
    CH5_UNROLL
    for (int j = 1; j < N; ++j) sum += *reinterpret_cast<const V*>(A + i + j * lda) * x[j];
    *reinterpret_cast<V*>(y + i) -= sum;
  }
  if constexpr (Width > 1) SubtractColumns<Width / 2, N>(m - i, A + i, lda, x, y + i);
}

// y −= Aᵀ x for N columns, likewise.
template <int Width, int N>
CH5_INLINE void SubtractRows(int m, const double* A, ptrdiff_t lda, const double* x, double* y) {
  using V = typename Register<Width>::Type;
  V sum[N] = {};
  int i = 0;
  for (; i + Width <= m; i += Width) {
    const V x_i = *reinterpret_cast<const V*>(x + i);
    CH5_UNROLL
    for (int j = 0; j < N; ++j) sum[j] += *reinterpret_cast<const V*>(A + i + j * lda) * x_i;
  }
  CH5_UNROLL
  for (int j = 0; j < N; ++j) {
    CH5_UNROLL
    for (int k = 0; k < Width; ++k) y[j] -= sum[j][k];
  }
  if constexpr (Width > 1) SubtractRows<Width / 2, N>(m - i, A + i, lda, x + i, y);
}

template <SimdLevel kSimd>
constexpr int kWidth = sizeof(FittingLanes<kSimd>) / sizeof(double);

// Calls strip(j, number) for the columns [j, j + number), `number` a constant: kStrip of them, and at the end one by one.
template <typename Strip>
CH5_INLINE void ForEachStrip(int n, const Strip& strip) {
  int j = 0;
  for (; j + kStrip <= n; j += kStrip) strip(j, std::integral_constant<int, kStrip>());
  for (; j < n; ++j) strip(j, std::integral_constant<int, 1>());
}

struct ProductAx {
  using Signature = void(int m, int n, const double* A, int lda, const double* x, double* y);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int m, int n, const double* A, ptrdiff_t lda, const double* x, double* y) {
    ForEachStrip(n, [&](int j, auto number) {
      SubtractColumns<kWidth<kSimd>, decltype(number)::value>(m, A + j * lda, lda, x + j, y);
    });
  }
};

struct ProductAtx {
  using Signature = void(int m, int n, const double* A, int lda, const double* x, double* y);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int m, int n, const double* A, ptrdiff_t lda, const double* x, double* y) {
    ForEachStrip(n, [&](int j, auto number) {
      SubtractRows<kWidth<kSimd>, decltype(number)::value>(m, A + j * lda, lda, x, y + j);
    });
  }
};

// C ← C B for three columns, likewise.
template <int Width>
CH5_INLINE void MultiplyThreeColumns(int m, const double* B, double* C, ptrdiff_t ldc) {
  using V = typename Register<Width>::Type;
  int i = 0;
  for (; i + Width <= m; i += Width) {
    V c[3];
    CH5_UNROLL
    for (int k = 0; k < 3; ++k) c[k] = *reinterpret_cast<const V*>(C + i + k * ldc);
    CH5_UNROLL
    for (int j = 0; j < 3; ++j) {
      *reinterpret_cast<V*>(C + i + j * ldc) = c[0] * B[3 * j] + c[1] * B[3 * j + 1] + c[2] * B[3 * j + 2];
    }
  }
  if constexpr (Width > 1) MultiplyThreeColumns<Width / 2>(m - i, B, C + i, ldc);
}

struct ThreeColumns {
  using Signature = void(int m, const double* B, double* C, int ldc);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int m, const double* B, double* C, ptrdiff_t ldc) {
    MultiplyThreeColumns<kWidth<kSimd>>(m, B, C, ldc);
  }
};

// A column's three numbers in one register, with the one below them, which stays as it is.
struct ThreeRows {
  using Signature = void(int n, const double* B, double* C, int ldc);
  template <SimdLevel>
  static CH5_INLINE void Run(int n, const double* B, double* C, ptrdiff_t ldc) {
    const Lanes b[4] = {
        {B[0], B[3], B[6], 0.0}, {B[1], B[4], B[7], 0.0}, {B[2], B[5], B[8], 0.0}, {0.0, 0.0, 0.0, 1.0}};
    for (int j = 0; j < n; ++j, C += ldc) *AsLanes(C) = b[0] * C[0] + b[1] * C[1] + b[2] * C[2] + b[3] * C[3];
  }
};

// x ← L⁻¹ x for N columns. The inverses do not wait for x.
template <int N>
CH5_INLINE void SolveTriangle(const double* L, ptrdiff_t ldl, double* x) {
  double y[N], inverse[N];
  CH5_UNROLL
  for (int c = 0; c < N; ++c) {
    y[c] = x[c];
    inverse[c] = 1.0 / L[c + c * ldl];
  }
  CH5_UNROLL
  for (int c = 0; c < N; ++c) {
    x[c] = y[c] *= inverse[c];
    CH5_UNROLL
    for (int r = c + 1; r < N; ++r) y[r] -= L[r + c * ldl] * y[c];
  }
}

// x ← L⁻ᵀ x.
template <int N>
CH5_INLINE void SolveTriangleTranspose(const double* L, ptrdiff_t ldl, double* x) {
  double y[N], inverse[N];
  CH5_UNROLL
  for (int c = 0; c < N; ++c) {
    y[c] = x[c];
    inverse[c] = 1.0 / L[c + c * ldl];
  }
  CH5_UNROLL
  for (int c = N - 1; c >= 0; --c) {
    x[c] = y[c] *= inverse[c];
    CH5_UNROLL
    for (int r = 0; r < c; ++r) y[r] -= L[c + r * ldl] * y[c];
  }
}

// Strip by strip: one is solved, then taken from the rows below.
struct Lower {
  using Signature = void(int k, const double* L, int ldl, double* x);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int k, const double* L, ptrdiff_t ldl, double* x) {
    ForEachStrip(k, [&](int j, auto number) {
      constexpr int kColumns = decltype(number)::value;
      const double* L_j = L + j * (ldl + 1);
      SolveTriangle<kColumns>(L_j, ldl, x + j);
      SubtractColumns<kWidth<kSimd>, kColumns>(k - j - kColumns, L_j + kColumns, ldl, x + j, x + j + kColumns);
    });
  }
};

// From the last strip to the first: the rows below are taken from a strip, then it is solved.
struct LowerTranspose {
  using Signature = void(int k, const double* L, int ldl, double* x);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int k, const double* L, ptrdiff_t ldl, double* x) {
    int j = k;
    const auto solve = [&](auto columns) {
      constexpr int kColumns = decltype(columns)::value;
      j -= kColumns;
      const double* L_j = L + j * (ldl + 1);
      SubtractRows<kWidth<kSimd>, kColumns>(k - j - kColumns, L_j + kColumns, ldl, x + j + kColumns, x + j);
      SolveTriangleTranspose<kColumns>(L_j, ldl, x + j);
    };
    while (j % kStrip != 0) solve(std::integral_constant<int, 1>());
    while (j > 0) solve(std::integral_constant<int, kStrip>());  // NOLINT(bugprone-infinite-loop): solve changes j
  }
};

}  // namespace

void SubtractProductAx(int m, int n, const double* A, int lda, const double* x, double* y) {
  Dispatch<ProductAx>()(m, n, A, lda, x, y);
}
void SubtractProductAtx(int m, int n, const double* A, int lda, const double* x, double* y) {
  Dispatch<ProductAtx>()(m, n, A, lda, x, y);
}
void MultiplyThreeColumns(int m, const double* B, double* C, int ldc) { Dispatch<ThreeColumns>()(m, B, C, ldc); }
void MultiplyThreeRows(int n, const double* B, double* C, int ldc) { Dispatch<ThreeRows>()(n, B, C, ldc); }
void SolveLower(int k, const double* L, int ldl, double* x) { Dispatch<Lower>()(k, L, ldl, x); }
void SolveLowerTranspose(int k, const double* L, int ldl, double* x) { Dispatch<LowerTranspose>()(k, L, ldl, x); }

}  // namespace ch5::kernels
