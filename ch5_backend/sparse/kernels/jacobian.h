#pragma once
/// An edge's Jacobians, and their products with each other. Every block has Stride(rows) numbers a column, Jacobians
/// Stride(columns) numbers a row; their padding is zero, so whole SIMD registers are computed. Blocks of H_pl have no padding.

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

/// A Jacobian with R rows and P columns, in registers of eight where `Wide`, the rest of a row in registers of four; A is
/// row-major with Stride(P) numbers a row, the padding zero.
template <int R, int P, bool Wide>
class Rows {
  static constexpr int kWide = Wide ? Stride(P) / kPack : 0, kFirst = kWide * kPack;  // the first of the rest
  static constexpr int kNarrow = (Stride(P) - kFirst) / kLanes;

 public:
  explicit CH5_INLINE Rows(const double* A) {
    CH5_UNROLL
    for (int r = 0; r < R; ++r, A += Stride(P)) {
      CH5_UNROLL
      for (int k = 0; k < kWide; ++k) wide_[r][k] = AsWide(A)[k];
      CH5_UNROLL
      for (int k = 0; k < kNarrow; ++k) narrow_[r][k] = AsLanes(A + kFirst)[k];
    }
  }

  /// C (P×Q) += AᵀB; B has R rows like A. Of the rows below C's diagonal, not all if `kUpper`.
  template <int Q, bool kUpper = false>
  CH5_INLINE void AddTransposeProduct(const double* B, double* C) const {
    CH5_UNROLL
    for (int c = 0; c < Q; ++c, C += Stride(P)) AddColumn<Stride(Q)>(B + c, kUpper ? c : P - 1, C);
  }

  /// The same for a C without padding, whose old values may be forgotten: nothing behind it is written, which may be
  /// another thread's.
  template <int Q>
  CH5_INLINE void AddTransposeProductTight(const double* B, bool forget, double* C) const {
    PrefetchPageAhead<P * Q>(C);
    CH5_UNROLL
    for (int c = 0; c < Q; ++c, C += P) {
      alignas(64) double sum[Stride(P)] = {};
      AddColumn<Stride(Q)>(B + c, P - 1, sum);
      CH5_UNROLL
      for (int k = 0; k < P / kLanes; ++k) {
        LanesInMemory* C_k = AsLanes(C + k * kLanes);
        *C_k = forget ? AsLanes(sum)[k] : *C_k + AsLanes(sum)[k];
      }
      CH5_UNROLL
      for (int i = P / kLanes * kLanes; i < P; ++i) C[i] = forget ? sum[i] : C[i] + sum[i];
    }
  }

  /// y (P, padded) −= Aᵀ r
  CH5_INLINE void SubtractTransposeVector(const double* r, double* y) const {
    const double minus[2] = {-r[0], -r[1]};
    static_assert(R == 2);
    AddColumn<1>(minus, P - 1, y);
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
};

}  // namespace ch5::kernels
