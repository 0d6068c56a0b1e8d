#pragma once
/// The innermost loops, on raw blocks. Sizes known at compile time unroll; Dynamic ones are read at run
/// time. Every block has Stride(rows) numbers a column (see linear/block_matrix.h), Jacobians Stride(columns) numbers a row;
/// their padding is zero, so whole SIMD registers are computed. Blocks of H_pl have no padding: a
/// read in whole registers runs on into the next block, and what is computed from that lies in the padding of the result.

#include <Eigen/Core>
#include <algorithm>

#include "ch5_backend/linear/block_matrix.h"
#include "ch5_backend/math/simd.h"

namespace ch5::kernels {

/// A size that is a constant where it is known at compile time.
template <int N>
CH5_INLINE constexpr int Pick(int size) {
  return N == Eigen::Dynamic ? size : N;
}

constexpr int ScratchSize(int rows, int columns) {
  return rows == Eigen::Dynamic || columns == Eigen::Dynamic ? Eigen::Dynamic : Stride(rows) * columns;
}

/// Zeroed memory for one landmark, aligned: on the stack where the size is known, else memory that each thread keeps,
/// apart for each `Index`.
template <int Size, int Index = 0>
struct Scratch {
  CH5_INLINE double* Zeros(int) {
    std::fill_n(values, Size, 0.0);
    return values;
  }
  alignas(32) double values[Size];
};
template <int Index>
struct Scratch<Eigen::Dynamic, Index> {
  static double* Zeros(int size) {
    thread_local AlignedVector values;
    values.assign(static_cast<size_t>(size), 0.0);
    return values.data();
  }
};

typedef float Floats __attribute__((vector_size(16), aligned(4), may_alias));
typedef float WideFloats __attribute__((vector_size(32), aligned(4), may_alias));
CH5_INLINE Floats* AsFloats(float* x) { return reinterpret_cast<Floats*>(x); }
CH5_INLINE const Floats* AsFloats(const float* x) { return reinterpret_cast<const Floats*>(x); }

/// Four numbers, widened where they are stored in single precision.
CH5_INLINE void LoadLanes(const double* x, Lanes* v) { *v = *AsLanes(x); }
CH5_INLINE void LoadLanes(const float* x, Lanes* v) { *v = __builtin_convertvector(*AsFloats(x), Lanes); }
/// x = v, or x += v.
CH5_INLINE void PutLanes(const Lanes& v, bool forget, double* x) { *AsLanes(x) = forget ? v : *AsLanes(x) + v; }
CH5_INLINE void PutLanes(const Lanes& v, bool forget, float* x) {
  const Floats narrow = __builtin_convertvector(v, Floats);
  *AsFloats(x) = forget ? narrow : *AsFloats(x) + narrow;
}

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

/// Asks for a block of H_pl one page ahead of the present one: processors do not foresee across pages.
template <int Size, typename Scalar>
CH5_INLINE void PrefetchPageAhead(const Scalar* x) {
  constexpr int kLine = 64 / static_cast<int>(sizeof(Scalar)), kPage = 4096 / static_cast<int>(sizeof(Scalar));
  CH5_UNROLL
  for (int i = 0; i < Size; i += kLine) __builtin_prefetch(x + kPage + i);
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
  template <int Q, typename Scalar>
  CH5_INLINE void AddTransposeProductTight(const double* B, bool forget, Scalar* C) const {
    PrefetchPageAhead<P * Q>(C);
    CH5_UNROLL
    for (int c = 0; c < Q; ++c, C += P) {
      alignas(64) double sum[Stride(P)] = {};
      AddColumn<Stride(Q)>(B + c, P - 1, sum);
      CH5_UNROLL
      for (int k = 0; k < P / kLanes; ++k) PutLanes(AsLanes(sum)[k], forget, C + k * kLanes);
      CH5_UNROLL
      for (int i = P / kLanes * kLanes; i < P; ++i) C[i] = static_cast<Scalar>(forget ? sum[i] : C[i] + sum[i]);
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

/// C (p×q) −= H Bᵀ;  H is p×l, B is q×l.
template <int P, int Q, int L>
CH5_INLINE void SubtractProduct(const double* H, const double* B, int p_size, int q_size, int l_size, double* C) {
  const int rows = Pick<P>(p_size), q = Pick<Q>(q_size), B_stride = Stride(q), l = Pick<L>(l_size);
  if constexpr (P != Eigen::Dynamic && Q != Eigen::Dynamic && L != Eigen::Dynamic) {
    constexpr int kP = Stride(P) / kLanes;
    Lanes a[L][kP];  // all of H stays in registers: 9 of them for a camera and a point
    CH5_UNROLL
    for (int m = 0; m < L; ++m) {
      CH5_UNROLL
      for (int k = 0; k < kP; ++k) a[m][k] = AsLanes(H + m * rows)[k];
    }
    CH5_UNROLL
    for (int c = 0; c < Q; ++c) {
      CH5_UNROLL
      for (int k = 0; k < kP; ++k) {
        Lanes sum = AsLanes(C)[c * kP + k];
        CH5_UNROLL
        for (int m = 0; m < L; ++m) sum -= a[m][k] * B[m * B_stride + c];
        AsLanes(C)[c * kP + k] = sum;
      }
    }
  } else {
    const int p = Stride(rows) / kLanes;
    for (int c = 0; c < q; ++c) {
      for (int k = 0; k < p; ++k) {
        Lanes sum = AsLanes(C)[c * p + k];
        for (int m = 0; m < l; ++m) sum -= AsLanes(H + m * rows)[k] * B[m * B_stride + c];
        AsLanes(C)[c * p + k] = sum;
      }
    }
  }
}

/// Y (p×l) = H V;  H is p×l, V l×l without padding, symmetric.
template <int P, int L>
CH5_INLINE void Multiply(const double* H, const double* V, int p_size, int l_size, double* Y) {
  const int rows = Pick<P>(p_size), p = Stride(rows) / kLanes, l = Pick<L>(l_size);
  for (int c = 0; c < l; ++c) {
    for (int k = 0; k < p; ++k) {
      Lanes sum = AsLanes(H)[k] * V[c * l];
      for (int m = 1; m < l; ++m) sum += AsLanes(H + m * rows)[k] * V[c * l + m];
      AsLanes(Y)[c * p + k] = sum;
    }
  }
}

/// y (p, padded) −= H x;  H is p×l.
template <int P, int L>
CH5_INLINE void SubtractProductVector(const double* H, const double* x, int p_size, int l_size, double* y) {
  const int rows = Pick<P>(p_size), p = Stride(rows) / kLanes, l = Pick<L>(l_size);
  for (int k = 0; k < p; ++k) {
    Lanes sum = AsLanes(y)[k];
    for (int m = 0; m < l; ++m) sum -= AsLanes(H + m * rows)[k] * x[m];
    AsLanes(y)[k] = sum;
  }
}

/// Σ Wᵀx over blocks H (P×L) of one landmark, summed across lanes only once.
template <int P, int L>
class TransposedSum {
 public:
  template <typename Scalar>
  CH5_INLINE void Add(const Scalar* H, const double* x) {
    PrefetchPageAhead<P * L>(H);
    CH5_UNROLL
    for (int m = 0; m < L; ++m, H += P) {
      CH5_UNROLL
      for (int k = 0; k < kWhole; ++k) {
        Lanes w;
        LoadLanes(H + k * kLanes, &w);
        sums_[m] += w * AsLanes(x)[k];
      }
      CH5_UNROLL
      for (int k = kWhole * kLanes; k < P; ++k) rest_[m] += H[k] * x[k];
    }
  }
  CH5_INLINE double At(int m) const { return rest_[m] + ((sums_[m][0] + sums_[m][1]) + (sums_[m][2] + sums_[m][3])); }

 private:
  static constexpr int kWhole = P / kLanes;
  Lanes sums_[L] = {};
  double rest_[L] = {};
};

/// y (l) += Wᵀx;  H is p×l.
template <int P, int L, typename Scalar>
CH5_INLINE void AddTransposed(const Scalar* H, const double* x, int p_size, int l_size, double* y) {
  const int p = Pick<P>(p_size), l = Pick<L>(l_size), whole = p / kLanes;
  for (int m = 0; m < l; ++m) {
    const Scalar* column = H + m * p;
    Lanes sums = {}, w;
    for (int k = 0; k < whole; ++k) {
      LoadLanes(column + k * kLanes, &w);
      sums += w * AsLanes(x)[k];
    }
    double sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    for (int k = whole * kLanes; k < p; ++k) sum += column[k] * x[k];
    y[m] += sum;
  }
}

/// y (l) += V x;  V is l×l without padding, symmetric.
template <int L>
CH5_INLINE void AddSymmetric(const double* V, const double* x, int l_size, double* y) {
  const int l = Pick<L>(l_size);
  for (int c = 0; c < l; ++c) {
    for (int k = 0; k < l; ++k) y[k] += V[c * l + k] * x[c];
  }
}

}  // namespace ch5::kernels
