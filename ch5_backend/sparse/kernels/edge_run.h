#pragma once
/// Products of Jacobians that lie in the lanes of packs, an edge in each: they are summed over the packs in registers, and
/// over the lanes only once at the end.

#include <algorithm>

#include "ch5_backend/sparse/kernels/jacobian.h"

namespace ch5::kernels {

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

/// Of a pack's edges: AᵀB for A with N columns and R rows and a column B.
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
