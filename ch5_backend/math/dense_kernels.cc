#include "ch5_backend/math/dense_kernels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ch5_backend/math/dispatch.h"

namespace ch5::kernels {
namespace {

// Six columns at a time: a pose has six degrees of freedom, so that most strips are full.
constexpr int kStrip = 6;
// Columns of A that are read before the next tile of rows: about as many pages as the TLB holds.
constexpr int kDepth = 64;
constexpr int kRows = 192;
// Triangles up to this size are factored without recursion; a multiple of kStrip.
constexpr int kTriangle = 96;
// Columns or rows that are one task.
constexpr int kChunk = 96;

// W, the numbers of a register, and R, the registers of rows in a tile.
template <SimdLevel kSimd>
constexpr int kWidth = sizeof(FittingLanes<kSimd>) / sizeof(double);
template <SimdLevel kSimd>
constexpr int kTileHeight = kSimd == SimdLevel::kAvx512 ? 3 : 2;

// C −= A Bᵀ for R·W rows, of which the first `rows` are stored, and kStrip columns, of which `columns` are stored.
template <int W, int R>
CH5_INLINE void Tile(int rows, int columns, int k, const double* A, int lda, const double* B, int ldb, double* C,
                     int ldc, bool forget) {
  using V = typename Register<W>::Type;
  V sum[R][kStrip] = {};
  for (int p = 0; p < k; ++p, A += lda, B += ldb) {
    V a[R];
    CH5_UNROLL
    for (int r = 0; r < R; ++r) a[r] = *reinterpret_cast<const V*>(A + r * W);
    CH5_UNROLL
    for (int j = 0; j < kStrip; ++j) {
      CH5_UNROLL
      for (int r = 0; r < R; ++r) sum[r][j] += a[r] * B[j];
    }
  }
  CH5_UNROLL
  for (int j = 0; j < kStrip; ++j) {
    if (j == columns) return;
    CH5_UNROLL
    for (int r = 0; r < R; ++r) {
      double* c = C + r * W + static_cast<long>(j) * ldc;
      if ((r + 1) * W <= rows) {
        V& stored = *reinterpret_cast<V*>(c);
        stored = forget ? -sum[r][j] : stored - sum[r][j];
      } else {
        for (int i = 0; i < rows - r * W; ++i) c[i] = (forget ? 0.0 : c[i]) - sum[r][j][i];
      }
    }
  }
}

// One strip of at most kStrip columns.
template <int W, int R>
CH5_INLINE void Strip(int m, int columns, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc,
                      bool forget) {
  for (int first = 0; first < k; first += kDepth) {
    const int depth = std::min(kDepth, k - first);
    const double* A_part = A + static_cast<long>(first) * lda;
    const double* B_part = B + static_cast<long>(first) * ldb;
    int i = 0;
    for (; i + (R - 1) * W < m; i += R * W) {
      Tile<W, R>(std::min(m - i, R * W), columns, depth, A_part + i, lda, B_part, ldb, C + i, ldc,
                 forget && first == 0);
    }
    if constexpr (R > 2) {
      if (i + W < m) {
        Tile<W, 2>(m - i, columns, depth, A_part + i, lda, B_part, ldb, C + i, ldc, forget && first == 0);
        i = m;
      }
    }
    if (i < m) Tile<W, 1>(m - i, columns, depth, A_part + i, lda, B_part, ldb, C + i, ldc, forget && first == 0);
  }
}

// In blocks of rows that stay in the second-level cache while all strips of B are read.
struct ProductABt {
  using Signature = void(int m, int n, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc,
                         bool forget);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int m, int n, int k, const double* A, int lda, const double* B, int ldb, double* C,
                             int ldc, bool forget) {
    for (int i = 0; i < m; i += kRows) {
      for (int j = 0; j < n; j += kStrip) {
        Strip<kWidth<kSimd>, kTileHeight<kSimd>>(std::min(kRows, m - i), std::min(kStrip, n - j), k, A + i, lda, B + j,
                                                 ldb, C + i + static_cast<long>(j) * ldc, ldc, forget);
      }
    }
  }
};

struct ProductAAt {
  using Signature = void(int n, int k, const double* A, int lda, double* C, int ldc, bool forget, int room);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int n, int k, const double* A, int lda, double* C, int ldc, bool forget, int room) {
    constexpr int W = kWidth<kSimd>;
    for (int i = 0; i < n; i += kRows) {
      const int end = std::min(n, i + kRows);
      for (int j = 0; j < end; j += kStrip) {
        const int begin = std::max(i, j), rows = end - begin;
        const int whole = end == n && room >= W - 1 ? (rows + W - 1) / W * W : rows;
        Strip<W, kTileHeight<kSimd>>(whole, std::min(kStrip, end - j), k, A + begin, lda, A + j, lda,
                                     C + begin + static_cast<long>(j) * ldc, ldc, forget);
      }
    }
  }
};

// L of a small block, and 1/L_jj. From pivot to pivot only one division is waited for: √d and 1/√d = √d/d stand aside.
template <int N>
CH5_INLINE bool FactorBlock(double* A, long lda, const double* min_pivot, double* inverse) {
  double a[N][N];
  CH5_UNROLL
  for (int j = 0; j < N; ++j) {
    CH5_UNROLL
    for (int i = j; i < N; ++i) a[j][i] = A[i + j * lda];
  }
  bool ok = true;
  CH5_UNROLL
  for (int j = 0; j < N; ++j) {
    const double d = a[j][j], inverse_d = 1.0 / d, root = std::sqrt(d);
    ok = ok && d > min_pivot[j] && d <= std::numeric_limits<double>::max();
    CH5_UNROLL
    for (int k = j + 1; k < N; ++k) {
      const double factor = a[j][k] * inverse_d;
      CH5_UNROLL
      for (int i = k; i < N; ++i) a[k][i] -= a[j][i] * factor;
    }
    inverse[j] = root * inverse_d;
    A[j + j * lda] = root;
    CH5_UNROLL
    for (int i = j + 1; i < N; ++i) A[i + j * lda] = a[j][i] * inverse[j];
  }
  return ok;
}
template <int N = kStrip>
CH5_INLINE bool FactorBlock(int n, double* A, long lda, const double* min_pivot, double* inverse) {
  if constexpr (N > 1) {
    if (n < N) return FactorBlock<N - 1>(n, A, lda, min_pivot, inverse);
  }
  return FactorBlock<N>(A, lda, min_pivot, inverse);
}

// X ← X L⁻ᵀ for W rows of X with N columns, all in registers.
template <int W, int N>
CH5_INLINE void SolveTile(const double* L, int ldl, const double* inverse, double* X, int ldx) {
  using V = typename Register<W>::Type;
  V x[N];
  CH5_UNROLL
  for (int j = 0; j < N; ++j) {
    x[j] = *reinterpret_cast<const V*>(X + static_cast<long>(j) * ldx);
    CH5_UNROLL
    for (int p = 0; p < j; ++p) x[j] -= x[p] * L[j + static_cast<long>(p) * ldl];
    x[j] *= inverse[j];
  }
  CH5_UNROLL
  for (int j = 0; j < N; ++j) *reinterpret_cast<V*>(X + static_cast<long>(j) * ldx) = x[j];
}

// The same for m rows: in whole registers, then in shorter ones.
template <int W>
CH5_INLINE void SolveTiles(int m, const double* L, int ldl, const double* inverse, double* X, int ldx) {
  int i = 0;
  for (; i + W <= m; i += W) SolveTile<W, kStrip>(L, ldl, inverse, X + i, ldx);
  if constexpr (W > 1) {
    if (i < m) SolveTiles<W / 2>(m - i, L, ldl, inverse, X + i, ldx);
  }
}

// The same for n ≤ kStrip columns; the last ones come one by one.
template <int W>
CH5_INLINE void SolveStrip(int m, int n, const double* L, int ldl, const double* inverse, double* X, int ldx) {
  if (n == kStrip) return SolveTiles<W>(m, L, ldl, inverse, X, ldx);
  for (int j = 0; j < n; ++j) {
    double* x = X + static_cast<long>(j) * ldx;
    for (int p = 0; p < j; ++p) {
      const double* y = X + static_cast<long>(p) * ldx;
      const double factor = L[j + static_cast<long>(p) * ldl];
      for (int r = 0; r < m; ++r) x[r] -= y[r] * factor;
    }
    for (int r = 0; r < m; ++r) x[r] *= inverse[j];
  }
}

// Left-looking: a strip is updated by all columns before it, then solved.
struct SolveTriangle {
  using Signature = void(int m, int k, const double* L, int ldl, double* X, int ldx);
  template <SimdLevel kSimd>
  static CH5_INLINE void Run(int m, int k, const double* L, int ldl, double* X, int ldx) {
    for (int j = 0; j < k; j += kStrip) {
      const int n = std::min(kStrip, k - j);
      const double* L_jj = L + j + static_cast<long>(j) * ldl;
      double inverse[kStrip], *strip = X + static_cast<long>(j) * ldx;
      for (int i = 0; i < n; ++i) inverse[i] = 1.0 / L_jj[i + static_cast<long>(i) * ldl];
      Strip<kWidth<kSimd>, kTileHeight<kSimd>>(m, n, j, X, ldx, L + j, ldl, strip, ldx, false);
      SolveStrip<kWidth<kSimd>>(m, n, L_jj, ldl, inverse, strip, ldx);
    }
  }
};

struct FactorTriangle {
  using Signature = bool(int k, double* A, int lda, const double* min_pivot);
  template <SimdLevel kSimd>
  static CH5_INLINE bool Run(int k, double* A, int lda, const double* min_pivot) {
    for (int j = 0; j < k; j += kStrip) {
      const int n = std::min(kStrip, k - j);
      double inverse[kStrip], *block = A + j + static_cast<long>(j) * lda;
      Strip<kWidth<kSimd>, kTileHeight<kSimd>>(k - j, n, j, A + j, lda, A + j, lda, block, lda, false);
      if (!FactorBlock(n, block, lda, min_pivot + j, inverse)) return false;
      SolveStrip<kWidth<kSimd>>(k - j - n, n, block, lda, inverse, block + n, lda);
    }
    return true;
  }
};

}  // namespace

void SubtractProductABt(int m, int n, int k, const double* A, int lda, const double* B, int ldb, double* C, int ldc,
                        Accumulate accumulate) {
  Dispatch<ProductABt>()(m, n, k, A, lda, B, ldb, C, ldc, accumulate == Accumulate::kNo);
}
void SubtractProductAAt(int n, int k, const double* A, int lda, double* C, int ldc, Accumulate accumulate, int room) {
  Dispatch<ProductAAt>()(n, k, A, lda, C, ldc, accumulate == Accumulate::kNo, room);
}

void Eliminate(int r, int k, const double* L_11, double* A_21, int lda, double* A_22, int lda_22, Accumulate accumulate,
               ThreadPool* pool) {
  ParallelFor(pool, r, kChunk, [&](int begin, int end) { SolveRows(end - begin, k, L_11, lda, A_21 + begin, lda); });
  ParallelFor(pool, r, kChunk, [&](int begin, int end) {
    const double *L_begin = A_21 + begin, *L_end = A_21 + end;
    double* diagonal = A_22 + begin + static_cast<long>(begin) * lda_22;
    SubtractProductAAt(end - begin, k, L_begin, lda, diagonal, lda_22, accumulate);
    SubtractProductABt(r - end, end - begin, k, L_end, lda, L_begin, lda, diagonal + end - begin, lda_22, accumulate);
  });
}

bool Factor(int k, double* A, int lda, const double* min_pivot, ThreadPool* pool) {
  if (k <= kTriangle) return Dispatch<FactorTriangle>()(k, A, lda, min_pivot);
  const int k_1 = k / 2 / kStrip * kStrip, k_2 = k - k_1;
  double *A_21 = A + k_1, *A_22 = A_21 + static_cast<long>(k_1) * lda;
  if (!Factor(k_1, A, lda, min_pivot, pool)) return false;
  Eliminate(k_2, k_1, A, A_21, lda, A_22, lda, Accumulate::kYes, pool);
  return Factor(k_2, A_22, lda, min_pivot + k_1, pool);
}

void SolveRows(int m, int k, const double* L, int ldl, double* X, int ldx) {
  if (k <= kTriangle) return Dispatch<SolveTriangle>()(m, k, L, ldl, X, ldx);
  const int k_1 = k / 2 / kStrip * kStrip, k_2 = k - k_1;
  const double* L_21 = L + k_1;
  double* X_2 = X + static_cast<long>(k_1) * ldx;
  SolveRows(m, k_1, L, ldl, X, ldx);
  SubtractProductABt(m, k_2, k_1, X, ldx, L_21, ldl, X_2, ldx);
  SolveRows(m, k_2, L_21 + static_cast<long>(k_1) * ldl, ldl, X_2, ldx);
}

}  // namespace ch5::kernels
