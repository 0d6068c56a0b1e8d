#pragma once
/// Jacobians, and their products with each other: of one edge (Rows), or of all edges of packs, one in each lane, which are
/// summed over the packs in registers, and over the lanes only once at the end (AddPackProducts).
///
/// Every block has Stride(rows) numbers a column, the Jacobians of one edge Stride(columns) numbers a row; their padding is
/// zero, so whole SIMD registers are computed. Blocks of H_pl have no padding.

#include <algorithm>

#include "ch5_backend/linear/block_matrix.h"
#include "ch5_backend/math/dispatch.h"

namespace ch5::kernels {

/// Four by four numbers, in place.
CH5_INLINE void Transpose(Lanes (&x)[4]) {
  Lanes ab_even, ab_odd, cd_even, cd_odd;
  Shuffle<0, 4, 2, 6>(x[0], x[1], &ab_even);
  Shuffle<1, 5, 3, 7>(x[0], x[1], &ab_odd);
  Shuffle<0, 4, 2, 6>(x[2], x[3], &cd_even);
  Shuffle<1, 5, 3, 7>(x[2], x[3], &cd_odd);
  Shuffle<0, 1, 4, 5>(ab_even, cd_even, &x[0]);
  Shuffle<0, 1, 4, 5>(ab_odd, cd_odd, &x[1]);
  Shuffle<2, 3, 6, 7>(ab_even, cd_even, &x[2]);
  Shuffle<2, 3, 6, 7>(ab_odd, cd_odd, &x[3]);
}

// ---- one edge ---------------------------------------------------------------------------------------------------

/// A Jacobian with R rows and P columns, in registers of eight where `Wide`, the rest of a row in registers of four; A is
/// row-major with Stride(P) numbers a row, the padding zero. Where P is UpTo(n), p is the size; likewise q.
template <int R, int P, bool Wide>
class Rows {
  static constexpr int kStride = Stride(kMost<P>);
  static constexpr int kWide = Wide ? kStride / kPack : 0, kFirst = kWide * kPack;  // the first of the rest
  static constexpr int kNarrow = (kStride - kFirst) / kLanes;

 public:
  explicit CH5_INLINE Rows(const double* A, int p = P) : p_(Pick<P>(p)) {
    CH5_UNROLL
    for (int r = 0; r < R; ++r, A += kStride) {
      CH5_UNROLL
      for (int k = 0; k < kWide; ++k) wide_[r][k] = AsWide(A)[k];
      CH5_UNROLL
      for (int k = 0; k < kNarrow; ++k) narrow_[r][k] = AsLanes(A + kFirst)[k];
    }
  }

  /// C (P×Q) += AᵀB; B has R rows like A. Of the rows below C's diagonal, not all if `kUpper`.
  template <int Q, bool kUpper = false>
  CH5_INLINE void AddTransposeProduct(const double* B, double* C, int q = Q) const {
    CH5_UNROLL
    for (int c = 0; c < kMost<Q>; ++c, C += kStride) {
      if (c < Pick<Q>(q)) AddColumn<Stride(kMost<Q>)>(B + c, kUpper ? c : kMost<P> - 1, C);
    }
  }

  /// The same for a C without padding, whose old values may be forgotten: nothing behind it is written, which may be
  /// another thread's.
  template <int Q>
  CH5_INLINE void AddTransposeProductTight(const double* B, bool forget, double* C) const {
    const int p = Pick<P>(p_), whole = p / kLanes;
    PrefetchPageAhead<kMost<P> * Q>(C);
    CH5_UNROLL
    for (int c = 0; c < Q; ++c, C += p) {
      alignas(64) double sum[kStride] = {};
      AddColumn<Stride(Q)>(B + c, kMost<P> - 1, sum);
      CH5_UNROLL
      for (int k = 0; k < kMost<P> / kLanes; ++k) {
        if (k >= whole) continue;
        LanesInMemory* C_k = AsLanes(C + k * kLanes);
        *C_k = forget ? AsLanes(sum)[k] : *C_k + AsLanes(sum)[k];
      }
      CH5_UNROLL
      for (int i = whole * kLanes; i < p; ++i) C[i] = forget ? sum[i] : C[i] + sum[i];
    }
  }

  /// y (P, padded) −= Aᵀ r
  CH5_INLINE void SubtractTransposeVector(const double* r, double* y) const {
    const double minus[2] = {-r[0], -r[1]};
    static_assert(R == 2);
    AddColumn<1>(minus, kMost<P> - 1, y);
  }

 private:
  // y += Aᵀb for the registers that begin at `last_row` or above; b's numbers lie Step apart.
  template <int Step>
  CH5_INLINE void AddColumn(const double* b, int last_row, double* y) const {
    CH5_UNROLL
    for (int k = 0; k < kWide; ++k) {
      if (k * kPack > last_row) continue;
      WideLanes sum = AsWide(y)[k];
      CH5_UNROLL
      for (int r = 0; r < R; ++r) sum += wide_[r][k] * b[r * Step];
      AsWide(y)[k] = sum;
    }
    CH5_UNROLL
    for (int k = 0; k < kNarrow; ++k) {
      if (kFirst + k * kLanes > last_row) continue;
      Lanes sum = AsLanes(y + kFirst)[k];
      CH5_UNROLL
      for (int r = 0; r < R; ++r) sum += narrow_[r][k] * b[r * Step];
      AsLanes(y + kFirst)[k] = sum;
    }
  }

  WideLanes wide_[R][kWide > 0 ? kWide : 1];
  Lanes narrow_[R][kNarrow > 0 ? kNarrow : 1];
  int p_;
};

// ---- packs of edges ---------------------------------------------------------------------------------------------

/// FittingLanes (math/simd.h) in a pack: one, two or four.
template <typename Vector>
constexpr int kParts = kPack * sizeof(double) / sizeof(Vector);

/// Numbers [0, 4) of the result are the sums over the lanes of x[0] … x[3].
CH5_INLINE void SumLanes(const Lanes* x, Lanes* sums) {
  Lanes columns[4] = {x[0], x[1], x[2], x[3]};
  Transpose(columns);
  *sums = (columns[0] + columns[1]) + (columns[2] + columns[3]);
}
CH5_INLINE void SumLanes(const NarrowLanes* x, Lanes* sums) {
  *sums = Lanes{x[0][0] + x[0][1], x[1][0] + x[1][1], x[2][0] + x[2][1], x[3][0] + x[3][1]};
}
CH5_INLINE void SumLanes(const WideLanes* x, Lanes* sums) {
  Lanes halves[4];
  CH5_UNROLL
  for (int i = 0; i < 4; ++i) {
    halves[i] = Lanes{x[i][0], x[i][1], x[i][2], x[i][3]} + Lanes{x[i][4], x[i][5], x[i][6], x[i][7]};
  }
  SumLanes(halves, sums);
}

/// The N numbers of each edge behind each other; x[i] has number i of two, four or eight edges.
template <int N>
CH5_INLINE void TurnPack(const NarrowLanes* x, double* of_edge) {
  CH5_UNROLL
  for (int i = 0; i < N; ++i) {
    of_edge[i] = x[i][0];
    of_edge[N + i] = x[i][1];
  }
}
template <int N>
CH5_INLINE void TurnPack(const Lanes* x, double* of_edge) {
  CH5_UNROLL
  for (int first = 0; first < N; first += kLanes) {
    Lanes turned[kLanes] = {x[first], x[first + 1], x[first + 2], x[first + 3]};
    Transpose(turned);
    CH5_UNROLL
    for (int k = 0; k < kLanes; ++k) *AsLanes(of_edge + k * N + first) = turned[k];
  }
}
template <int N>
CH5_INLINE void TurnPack(const WideLanes* x, double* of_edge) {
  Lanes low[N], high[N];
  CH5_UNROLL
  for (int i = 0; i < N; ++i) {
    low[i] = Lanes{x[i][0], x[i][1], x[i][2], x[i][3]};
    high[i] = Lanes{x[i][4], x[i][5], x[i][6], x[i][7]};
  }
  TurnPack<N>(low, of_edge);
  TurnPack<N>(high, of_edge + kLanes * N);
}

/// The size of ξ. An A below is a RelativeJacobian (graph/fast_edge.h): 6×6, row-major, kPack numbers a row, zero in its
/// lower left quarter.
constexpr int kXi = 6;
constexpr bool IsZero(int row, int column) { return row >= 3 && column < 3; }

/// AᵀB for the edges of a pack, where A has R rows and N columns and B is a column.
template <int R, typename Vector, int N>
CH5_INLINE void LanesTransposeProduct(const double* A, const double* B, Vector (*products)[N]) {
  CH5_UNROLL
  for (int part = 0; part < kParts<Vector>; ++part, A += kPack / kParts<Vector>, B += kPack / kParts<Vector>) {
    CH5_UNROLL
    for (int i = 0; i < N; ++i) {
      Vector a, b;
      products[part][i] = Vector{};
      CH5_UNROLL
      for (int r = 0; r < R; ++r) {
        Load(A + (i * R + r) * kPack, &a);
        Load(B + r * kPack, &b);
        products[part][i] += a * b;
      }
    }
  }
}
/// Aᵀx of each edge, kPack numbers an edge of which two have no meaning; A is the same for all.
template <typename Vector>
CH5_INLINE void LanesTransposeProduct(const double* A, const Vector (*x)[kXi], double* of_edge) {
  CH5_UNROLL
  for (int part = 0; part < kParts<Vector>; ++part, of_edge += kPack * kPack / kParts<Vector>) {
    Vector products[kPack] = {};
    CH5_UNROLL
    for (int c = 0; c < kXi; ++c) {
      CH5_UNROLL
      for (int k = 0; k < kXi; ++k) {
        if (!IsZero(k, c)) products[c] += A[k * kPack + c] * x[part][k];
      }
    }
    TurnPack<kPack>(products, of_edge);
  }
}

/// B = H A; columns of kPack numbers.
template <typename Vector>
CH5_INLINE void Product(const double* H, const double* A, double* B) {
  constexpr int kWidth = kPack / kParts<Vector>;
  CH5_UNROLL
  for (int c = 0; c < kXi; ++c) {
    CH5_UNROLL
    for (int part = 0; part < kPack; part += kWidth) {
      Vector sum = {}, column;
      CH5_UNROLL
      for (int k = 0; k < kXi; ++k) {
        if (IsZero(k, c)) continue;
        Load(H + k * kPack + part, &column);
        sum += A[k * kPack + c] * column;
      }
      Store(sum, B + c * kPack + part);
    }
  }
}
/// C (N columns of kPack numbers) += AᵀB
template <typename Vector, int N>
CH5_INLINE void AddTransposeProduct(const double* A, const double* B, double* C) {
  constexpr int kWidth = kPack / kParts<Vector>;
  CH5_UNROLL
  for (int part = 0; part < kPack; part += kWidth) {
    Vector rows[kXi];
    CH5_UNROLL
    for (int k = 0; k < kXi; ++k) Load(A + k * kPack + part, rows + k);
    CH5_UNROLL
    for (int c = 0; c < N; ++c) {
      Vector sum;
      Load(C + c * kPack + part, &sum);
      CH5_UNROLL
      for (int k = 0; k < kXi; ++k) sum += rows[k] * B[c * kPack + k];
      Store(sum, C + c * kPack + part);
    }
  }
}

/// y (P, without padding) += x
template <int P>
CH5_INLINE void AddTight(const double* x, double* y) {
  CH5_UNROLL
  for (int k = 0; k < P / kLanes; ++k) AsLanes(y)[k] += AsLanes(x)[k];
  CH5_UNROLL
  for (int i = P / kLanes * kLanes; i < P; ++i) y[i] += x[i];
}

/// C (P×Q, Stride(P) numbers a column) += Σ AᵀB over all lanes of `packs` packs, which lie `step` numbers apart; A and B
/// have R rows and are column-major. Only the upper half of C, at least, if `kUpper`. `Tile` columns of C at a time, as many
/// as there are registers for.
template <typename Vector, int R, int P, int Q, int Tile, bool kUpper = false, int First = 0>
CH5_INLINE void AddPackProducts(const double* A, const double* B, int packs, int step, double* C) {
  constexpr int kTile = std::min(Tile, Q - First), kRows = kUpper ? std::min(P, First + kTile) : P;
  constexpr int kWidth = kPack / kParts<Vector>;
  Vector sums[kTile][Stride(P)] = {};
  for (int k = 0; k < packs; ++k) {
    CH5_UNROLL
    for (int part = 0; part < kParts<Vector>; ++part) {
      const double *a = A + k * step + part * kWidth, *b = B + k * step + part * kWidth + First * R * kPack;
      CH5_UNROLL
      for (int r = 0; r < R; ++r) {
        Vector b_r[kTile], a_ir;
        CH5_UNROLL
        for (int c = 0; c < kTile; ++c) Load(b + (c * R + r) * kPack, b_r + c);
        CH5_UNROLL
        for (int i = 0; i < kRows; ++i) {
          Load(a + (i * R + r) * kPack, &a_ir);
          CH5_UNROLL
          for (int c = 0; c < kTile; ++c) sums[c][i] += a_ir * b_r[c];
        }
      }
    }
  }
  CH5_UNROLL
  for (int c = 0; c < kTile; ++c) {
    CH5_UNROLL
    for (int i = 0; i < kRows; i += kLanes) {
      Lanes sum;
      SumLanes(&sums[c][i], &sum);
      *AsLanes(C + (First + c) * Stride(P) + i) += sum;
    }
  }
  if constexpr (First + kTile < Q) AddPackProducts<Vector, R, P, Q, Tile, kUpper, First + kTile>(A, B, packs, step, C);
}

}  // namespace ch5::kernels
