#include "ch5_backend/sparse/kernels/schur_group.h"

#include <algorithm>

#include "ch5_backend/sparse/kernels/blocks.h"

namespace ch5::kernels {
namespace {

constexpr int kColumns = 24;  // of A at a time: A then stays in the first-level cache
constexpr int kMostRows = Stride(9);

CH5_INLINE void LoadWide(const double* x, WideLanes* v) { *v = *AsWide(x); }
CH5_INLINE void LoadWide(const float* x, WideLanes* v) {
  *v = __builtin_convertvector(*reinterpret_cast<const WideFloats*>(x), WideLanes);
}

// What any 64-bit processor has.
typedef double Pair __attribute__((vector_size(16)));
typedef double PairInMemory __attribute__((vector_size(16), aligned(8)));

CH5_INLINE void Load(const double* x, Pair* v) { *v = *reinterpret_cast<const PairInMemory*>(x); }
CH5_INLINE void Subtract(const Pair& v, double* x) { *reinterpret_cast<PairInMemory*>(x) -= v; }
CH5_INLINE void Load(const double* x, Lanes* v) { *v = *AsLanes(x); }
CH5_INLINE void Load(const double* x, WideLanes* v) { *v = *AsWide(x); }
CH5_INLINE void Subtract(const Lanes& v, double* x) { *AsLanes(x) -= v; }
CH5_INLINE void Subtract(const WideLanes& v, double* x) { *AsWide(x) -= v; }

// S (P×P) −= A Bᵀ over k columns; `Tile` columns of S at a time, as many as there are registers for. `Vector` is never
// wider than the processor's registers: GCC 12 takes longer ones apart through memory, which costs six times as much.
template <int P, typename Vector, int Tile, int First = 0>
CH5_INLINE void SubtractPair(const double* A, const double* B, int k, double* S) {
  constexpr int kRows = Stride(P), kTile = std::min(Tile, P - First);
  constexpr int kWidth = static_cast<int>(sizeof(Vector) / sizeof(double)), kWhole = kRows / kWidth;
  constexpr bool kRest = kRows % kWidth != 0;  // four rows
  Vector whole[kTile][kWhole] = {};
  Lanes rest[kTile] = {};
  const double *a = A, *b = B + First;
  for (int p = 0; p < k; ++p, a += kRows, b += kRows) {
    Vector rows[kWhole];
    CH5_UNROLL
    for (int r = 0; r < kWhole; ++r) Load(a + r * kWidth, &rows[r]);
    CH5_UNROLL
    for (int c = 0; c < kTile; ++c) {
      CH5_UNROLL
      for (int r = 0; r < kWhole; ++r) whole[c][r] += rows[r] * b[c];
      if constexpr (kRest) rest[c] += *AsLanes(a + kRows - kLanes) * b[c];
    }
  }
  CH5_UNROLL
  for (int c = 0; c < kTile; ++c) {
    double* column = S + (First + c) * kRows;
    CH5_UNROLL
    for (int r = 0; r < kWhole; ++r) Subtract(whole[c][r], column + r * kWidth);
    if constexpr (kRest) *AsLanes(column + kRows - kLanes) -= rest[c];
  }
  if constexpr (First + kTile < P) SubtractPair<P, Vector, Tile, First + kTile>(A, B, k, S);
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

template <int P, int L, typename Scalar>
struct SubtractGroup {
  using Signature = void(const Structure&, const Linearized&, const SchurGroups&, const SchurGroup&, const PoseRange&,
                         double* A, Eliminated*);
  static constexpr int kBlock = Stride(P) * L, kBatch = kColumns / L;
  static constexpr int kPoseSize = kBatch * kBlock;  // from A_i to A_i+1

  template <SimdLevel kSimd>
  static CH5_INLINE void Run(const Structure& s, const Linearized& y, const SchurGroups& groups,
                             const SchurGroup& group, const PoseRange& range, double* A, Eliminated* out) {
    const GroupPose* poses = groups.poses.data() + group.poses_begin;
    const int n = group.poses_end - group.poses_begin;
    const int begin = static_cast<int>(range.begin - poses), end = static_cast<int>(range.end - poses);
    for (int l = group.first; l < group.last; l += kBatch) {
      const int count = std::min(kBatch, group.last - l);
      double rhs[kColumns];  // G⁻¹b
      FillColumns(s, y, *out, l, count, begin, n, A, rhs);
      for (int j = begin; j < end; ++j) {
        const double* A_j = A + j * kPoseSize;
        const int* block = groups.blocks.data() + group.blocks_begin + j * n - j * (j - 1) / 2;
        for (int i = j; i < n; ++i) SubtractFromBlock<kSimd>(A + i * kPoseSize, A_j, count, out->S.Values(*block++));
        SubtractVector<P>(A_j, rhs, count * L, out->b_S.data() + s.pose_offset[poses[j].pose]);
      }
    }
  }

 private:
  // A_i = [H_il G_l⁻ᵀ …] for the poses i ≥ begin, and G⁻¹b, of landmarks [first, first + count).
  static CH5_INLINE void FillColumns(const Structure& s, const Linearized& y, const Eliminated& eliminated, int first,
                                     int count, int begin, int n, double* A, double* rhs) {
    const Scalar* H_pl = y.H_pl.Numbers<Scalar>() + s.slot_block[s.landmark_slots[first]];
    const double* G_inverse = &eliminated.G_inverse[s.landmark_block[first]];
    for (int k = 0; k < count; ++k, G_inverse += L * L) {
      const double* b = y.b.data() + s.landmark_offset[first + k];
      for (int c = 0; c < L; ++c) {
        rhs[k * L + c] = G_inverse[c] * b[0];
        for (int m = 1; m <= c; ++m) rhs[k * L + c] += G_inverse[m * L + c] * b[m];
      }
      for (int i = begin; i < n; ++i) {
        const Scalar* H_il = H_pl + (k * n + i) * P * L;
        PrefetchPageAhead<P * L>(H_il);
        Scale<P, L>(H_il, G_inverse, A + i * kPoseSize + k * kBlock);
      }
    }
  }

  // S_ij −= A_i A_jᵀ over the columns of `count` landmarks.
  template <SimdLevel kSimd>
  static CH5_INLINE void SubtractFromBlock(const double* A_i, const double* A_j, int count, double* S_ij) {
    if constexpr (P == 9 && kSimd == SimdLevel::kAvx512) {
      count == 1 ? SubtractPairAndRow<P, L>(A_i, A_j, L, S_ij) : SubtractPairAndRow<P, 0>(A_i, A_j, count * L, S_ij);
    } else if constexpr (kSimd == SimdLevel::kAvx512) {
      SubtractPair<P, WideLanes, 9>(A_i, A_j, count * L, S_ij);
    } else if constexpr (kSimd == SimdLevel::kAvx2) {
      SubtractPair<P, Lanes, 4>(A_i, A_j, count * L, S_ij);
    } else {
      SubtractPair<P, Pair, 2>(A_i, A_j, count * L, S_ij);
    }
  }
};

// The general variant is in eliminate.cc.
template <typename Scalar>
struct SubtractGroup<Eigen::Dynamic, Eigen::Dynamic, Scalar> {
  using Signature = void(const Structure&, const Linearized&, const SchurGroups&, const SchurGroup&, const PoseRange&,
                         double* A, Eliminated*);
  template <SimdLevel>
  static CH5_INLINE void Run(const Structure&, const Linearized&, const SchurGroups&, const SchurGroup&,
                             const PoseRange&, double*, Eliminated*) {}
};

}  // namespace

SubtractGroupFunction SubtractGroupFor(const BlockSizes& sizes) {
  return sizes.AreFixed() ? Dispatch<SubtractGroup>(sizes) : nullptr;
}

GroupMemory FixedSizeMemory(int poses, int /*rows*/) { return {static_cast<size_t>(poses) * kColumns * kMostRows, 0}; }

}  // namespace ch5::kernels
