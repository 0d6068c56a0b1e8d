#include "ch5_backend/sparse/schur_group.h"

#include <algorithm>

#include "ch5_backend/sparse/block_kernels.h"

namespace ch5 {
namespace {

constexpr int kColumns = 24;  // of A at a time: A then stays in the first-level cache
constexpr int kMostRows = Stride(9);

CH5_INLINE void LoadWide(const double* x, WideLanes* v) { *v = *AsWide(x); }
CH5_INLINE void LoadWide(const float* x, WideLanes* v) {
  *v = __builtin_convertvector(*reinterpret_cast<const kernels::WideFloats*>(x), WideLanes);
}

// S (P×P) −= A Bᵀ over k columns; `Tile` columns of S at a time, as many as there are registers for.
template <int P, int Tile, int First = 0>
CH5_INLINE void SubtractPair(const double* A, const double* B, int k, double* S) {
  constexpr int kRows = Stride(P), kTile = std::min(Tile, P - First);
  constexpr bool kWide = kRows >= 8, kNarrow = kRows % 8 != 0;
  WideLanes wide[kTile] = {};
  Lanes narrow[kTile] = {};
  const double *a = A, *b = B + First;
  for (int p = 0; p < k; ++p, a += kRows, b += kRows) {
    CH5_UNROLL
    for (int c = 0; c < kTile; ++c) {
      if constexpr (kWide) wide[c] += *AsWide(a) * b[c];
      if constexpr (kNarrow) narrow[c] += *AsLanes(a + kRows - kLanes) * b[c];
    }
  }
  CH5_UNROLL
  for (int c = 0; c < kTile; ++c) {
    double* column = S + (First + c) * kRows;
    if constexpr (kWide) *AsWide(column) -= wide[c];
    if constexpr (kNarrow) *AsLanes(column + kRows - kLanes) -= narrow[c];
  }
  if constexpr (First + kTile < P) SubtractPair<P, Tile, First + kTile>(A, B, k, S);
}

// The same for one row more than a whole register: its products with B's rows go along B. For 32 registers. K columns
// known at compile time are worth code of their own, or 0.
template <int P, int K>
CH5_INLINE void SubtractPairAndRow(const double* A, const double* B, int k, double* S) {
  static_assert(P == 9);
  WideLanes block[P] = {}, row = {};
  double corner = 0.0;
  const int columns = K > 0 ? K : k;
  CH5_UNROLL
  for (int p = 0; p < columns; ++p, A += Stride(P), B += Stride(P)) {
    const WideLanes a = *AsWide(A);
    CH5_UNROLL
    for (int c = 0; c < P; ++c) block[c] += a * B[c];
    row += *AsWide(B) * A[8];
    corner += A[8] * B[8];
  }
  CH5_UNROLL
  for (int c = 0; c < P; ++c, S += Stride(P)) {
    *AsWide(S) -= block[c];
    S[8] -= c < 8 ? row[c % 8] : corner;
  }
}

// b (P, without padding) −= A x over k columns.
template <int P>
CH5_INLINE void SubtractVector(const double* A, const double* x, int k, double* b) {
  constexpr int kPerColumn = Stride(P) / kLanes;
  Lanes sum[kPerColumn] = {};
  for (int p = 0; p < k; ++p, A += Stride(P)) {
    CH5_UNROLL
    for (int i = 0; i < kPerColumn; ++i) sum[i] += AsLanes(A)[i] * x[p];
  }
  CH5_UNROLL
  for (int i = 0; i < P; ++i) b[i] -= sum[i / kLanes][i % kLanes];
}

// The last rows of a column that has no padding; zeros take its place.
template <int P, typename Scalar>
CH5_INLINE void LoadLastRows(const Scalar* column, Lanes* rows) {
  constexpr int kFirst = Stride(P) - kLanes;
  const auto at = [&](int i) { return kFirst + i < P ? static_cast<double>(column[kFirst + i]) : 0.0; };
  *rows = Lanes{at(0), at(1), at(2), at(3)};
}

// A (P×L) = H_pl G⁻ᵀ, written in the registers' widths in which it will be read: a wide read of narrow writes would wait.
template <int P, int L, typename Scalar>
CH5_INLINE void Scale(const Scalar* H_pl, const double* root, double* A) {
  constexpr int kRows = Stride(P);
  constexpr bool kWide = kRows >= 8, kNarrow = kRows % 8 != 0;
  CH5_UNROLL
  for (int c = 0; c < L; ++c) {
    if constexpr (kWide) {
      WideLanes rows, sum;
      LoadWide(H_pl, &rows);
      sum = rows * root[c];
      CH5_UNROLL
      for (int m = 1; m <= c; ++m) {
        LoadWide(H_pl + m * P, &rows);
        sum += rows * root[m * L + c];
      }
      *AsWide(A + c * kRows) = sum;
    }
    if constexpr (kNarrow) {
      Lanes rows, sum;
      LoadLastRows<P>(H_pl, &rows);
      sum = rows * root[c];
      CH5_UNROLL
      for (int m = 1; m <= c; ++m) {
        LoadLastRows<P>(H_pl + m * P, &rows);
        sum += rows * root[m * L + c];
      }
      *AsLanes(A + (c + 1) * kRows - kLanes) = sum;
    }
  }
}

template <int P, int L, typename Scalar, int Tile>
CH5_INLINE void Take(BlockSystem* system, const SchurGroup& group, double* A) {
  constexpr int kBlock = Stride(P) * L, kBatch = kColumns / L;
  constexpr int kSeat = kBatch * kBlock;  // from A_i to A_i+1
  BlockSystem& y = *system;
  const BlockStructure& s = y.structure;
  const int *pose = &s.slot_pose[s.landmark_slots[group.first]], n = group.seats;
  for (int l = group.first; l < group.last; l += kBatch) {
    const int count = std::min(kBatch, group.last - l);
    const Scalar* H_pm = BlocksOf<Scalar>(y.H_pm) + s.slot_block[s.landmark_slots[l]];
    const double* root = &y.H_mm_root[s.landmark_block[l]];
    double rhs[kColumns];  // G⁻¹b
    for (int k = 0; k < count; ++k, root += L * L) {
      const double* b = y.b.data() + s.landmark_offset[l + k];
      for (int c = 0; c < L; ++c) {
        rhs[k * L + c] = root[c] * b[0];
        for (int m = 1; m <= c; ++m) rhs[k * L + c] += root[m * L + c] * b[m];
      }
      for (int i = group.first_seat; i < n; ++i) {
        const Scalar* H_pl = H_pm + (k * n + i) * P * L;
        kernels::PrefetchPageAhead<P * L>(H_pl);
        Scale<P, L>(H_pl, root, A + i * kSeat + k * kBlock);
      }
    }
    for (int j = group.first_seat; j < group.end_seat; ++j) {
      const double* A_j = A + j * kSeat;
      const int* block = group.blocks + j * n - j * (j - 1) / 2;
      for (int i = j; i < n; ++i) {
        const double* A_i = A + i * kSeat;
        double* S_ij = y.S.Values(*block++);
        if constexpr (P == 9 && Tile == P) {
          count == 1 ? SubtractPairAndRow<P, L>(A_i, A_j, L, S_ij)
                     : SubtractPairAndRow<P, 0>(A_i, A_j, count * L, S_ij);
        } else {
          SubtractPair<P, Tile>(A_i, A_j, count * L, S_ij);
        }
      }
      SubtractVector<P>(A_j, rhs, count * L, y.b_schur.data() + s.pose_offset[pose[j]]);
    }
  }
}

template <int P, int L, typename Scalar>
struct Taker {
  static void Portable(BlockSystem* y, const SchurGroup& group, double* A) { Take<P, L, Scalar, 4>(y, group, A); }
  CH5_WITH_AVX2 static void Avx2(BlockSystem* y, const SchurGroup& group, double* A) {
    Take<P, L, Scalar, 4>(y, group, A);
  }
  CH5_WITH_AVX512 static void Avx512(BlockSystem* y, const SchurGroup& group, double* A) {
    Take<P, L, Scalar, 9>(y, group, A);
  }
  static TakeSchurGroup Choose() { return HasAvx512() ? Avx512 : HasAvx2() ? Avx2 : Portable; }
};

template <typename Scalar>
TakeSchurGroup Choose(int pose_dim, int landmark_dim) {
  if (pose_dim == 6 && landmark_dim == 1) return Taker<6, 1, Scalar>::Choose();
  if (pose_dim == 6 && landmark_dim == 3) return Taker<6, 3, Scalar>::Choose();
  if (pose_dim == 9 && landmark_dim == 3) return Taker<9, 3, Scalar>::Choose();
  return nullptr;
}

}  // namespace

TakeSchurGroup SchurGroupFor(int pose_dim, int landmark_dim, bool single_precision) {
  return single_precision ? Choose<float>(pose_dim, landmark_dim) : Choose<double>(pose_dim, landmark_dim);
}

size_t SchurGroupRoom(int seats) { return static_cast<size_t>(seats) * kColumns * kMostRows; }

}  // namespace ch5
