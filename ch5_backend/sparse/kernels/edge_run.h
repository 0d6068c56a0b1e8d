#pragma once
/// Products of Jacobians that lie in the lanes of packs, an edge in each: they are summed over the packs in registers, and
/// over the lanes only once at the end.

#include <algorithm>

#include "ch5_backend/sparse/kernels/jacobian.h"

namespace ch5::kernels {

/// Numbers [0, 4) of the result are the sums over the lanes of x[0] … x[3].
CH5_INLINE void SumLanes(const WideLanes* x, Lanes* sums) {
  Lanes halves[4];
  CH5_UNROLL
  for (int i = 0; i < 4; ++i) {
    halves[i] = Lanes{x[i][0], x[i][1], x[i][2], x[i][3]} + Lanes{x[i][4], x[i][5], x[i][6], x[i][7]};
  }
  Transpose(halves);
  *sums = (halves[0] + halves[1]) + (halves[2] + halves[3]);
}

/// The N numbers of each edge behind each other; x[i] has number i of all edges.
template <int N>
CH5_INLINE void TurnPack(const WideLanes* x, double* of_edge) {
  CH5_UNROLL
  for (int first = 0; first < N; first += kLanes) {
    Lanes low[kLanes], high[kLanes];
    CH5_UNROLL
    for (int i = 0; i < kLanes; ++i) {
      const WideLanes& v = x[first + i];
      low[i] = Lanes{v[0], v[1], v[2], v[3]};
      high[i] = Lanes{v[4], v[5], v[6], v[7]};
    }
    Transpose(low);
    Transpose(high);
    CH5_UNROLL
    for (int k = 0; k < kLanes; ++k) {
      *AsLanes(of_edge + k * N + first) = low[k];
      *AsLanes(of_edge + (kLanes + k) * N + first) = high[k];
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
template <int R, int P, int Q, int Tile, bool kUpper = false, int First = 0>
CH5_INLINE void AddPackProducts(const double* A, const double* B, int packs, int step, double* C) {
  constexpr int kTile = std::min(Tile, Q - First), kRows = kUpper ? std::min(P, First + kTile) : P;
  WideLanes sums[kTile][Stride(P)] = {};
  for (int k = 0; k < packs; ++k) {
    const auto *a = AsWide(A + k * step), *b = AsWide(B + k * step) + First * R;
    CH5_UNROLL
    for (int r = 0; r < R; ++r) {
      CH5_UNROLL
      for (int i = 0; i < kRows; ++i) {
        CH5_UNROLL
        for (int c = 0; c < kTile; ++c) sums[c][i] += a[i * R + r] * b[c * R + r];
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
  if constexpr (First + kTile < Q) AddPackProducts<R, P, Q, Tile, kUpper, First + kTile>(A, B, packs, step, C);
}

}  // namespace ch5::kernels
