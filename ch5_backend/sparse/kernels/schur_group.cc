#include "ch5_backend/sparse/kernels/schur_group.h"

#include <algorithm>

#include "ch5_backend/math/dense_kernels.h"

namespace ch5::kernels {
namespace {

// ---- any sizes --------------------------------------------------------------------------------------------------

// The group's A_i below each other, and G⁻¹b as the last row,
//
//      ┌ H_1l G_l⁻ᵀ │ H_1m G_m⁻ᵀ │ … ┐    a row of blocks for each pose, a column for each landmark of the group;
//  A = │ H_2l G_l⁻ᵀ │ H_2m G_m⁻ᵀ │ … │    C = −A Aᵀ, of which the lower half is needed, holds the group's part of S,
//      └ (G_l⁻¹b_l)ᵀ│ (G_m⁻¹b_m)ᵀ│ … ┘    and in its last row that of b_S
//
// of which a thread needs the rows from its first pose on and the columns up to its last.
constexpr int kRoom = 2 * kLanes;      // behind the columns of A and C, for whole vectors
constexpr int kColumnsOfGeneral = 60;  // of A at a time: they stay in the first-level cache

int LeadingDimension(int rows) { return Padded(rows + 1) + kRoom; }
// How many numbers A has; C begins after them.
size_t SizeOfA(int lda) { return static_cast<size_t>(lda) * (kColumnsOfGeneral + 8) + kOverread; }

// The columns of A that belong to landmark l:  H_pl G⁻ᵀ, and G⁻¹b. Whole registers are written; what is too much lies
// where the next pose will write.
void FillColumns(const GroupSystem& y, const PoseRange& range, int l, int lda, double* A_l) {
  const int dim = y.landmark_dim, top = range.begin->row;
  const double* H_pl = y.slots.Block(y.slots.begin) + l * dim * y.rows;
  const double *G_inverse = y.G_inverse + l * dim * dim, *b = y.b + y.b_offset[l];
  for (const GroupPose* pose = range.begin; pose != y.poses_end; ++pose) {
    const double* H_il = H_pl + pose->row * dim;
    double* A = A_l + pose->row - top;
    for (int c = 0; c < dim; ++c) {
      for (int k = 0; k < Stride(pose->dim) / kLanes; ++k) {
        Lanes sum = AsLanes(H_il)[k] * G_inverse[c];
        for (int m = 1; m <= c; ++m) sum += AsLanes(H_il + m * pose->dim)[k] * G_inverse[m * dim + c];
        AsLanes(A + c * lda)[k] = sum;
      }
    }
  }
  for (int c = 0; c < dim; ++c) {
    double sum = 0.0;
    for (int m = 0; m <= c; ++m) sum += G_inverse[m * dim + c] * b[m];
    A_l[y.rows - top + c * lda] = sum;
  }
}

// S and b_S take their blocks of C.
void AddBlocks(const GroupSystem& y, const PoseRange& range, int lda, const double* C, SymmetricBlockMatrix* S,
               double* b_S) {
  const auto n = static_cast<int>(y.poses_end - y.poses);
  const int top = range.begin->row;
  for (const GroupPose* j = range.begin; j != range.end; ++j) {
    const auto k = static_cast<int>(j - y.poses);
    const int* block = y.blocks + k * n - k * (k - 1) / 2;
    const double* column = C + static_cast<ptrdiff_t>(j->row - top) * lda;
    for (const GroupPose* i = j; i != y.poses_end; ++i) {
      const double* C_ij = column + i->row - top;
      double* S_ij = S->Values(*block++);
      for (int c = 0; c < j->dim; ++c, C_ij += lda, S_ij += Stride(i->dim)) {
        for (int r = 0; r < i->dim; ++r) S_ij[r] += C_ij[r];
      }
    }
    for (int c = 0; c < j->dim; ++c) b_S[j->offset + c] += column[c * lda + y.rows - top];
  }
}

void SubtractGeneralGroup(const GroupSystem& y, const PoseRange& range, double* A, SymmetricBlockMatrix* S,
                          double* b_S) {
  const int top = range.begin->row, rows = y.rows - top, lda = LeadingDimension(rows), dim = y.landmark_dim;
  const int columns = range.end == y.poses_end ? rows + 1 : range.end->row - top;
  const int batch = std::max(1, kColumnsOfGeneral / dim);
  double* C = A + SizeOfA(lda);
  for (int first = 0; first < y.num_landmarks; first += batch) {
    const int count = std::min(batch, y.num_landmarks - first), k = count * dim;
    for (int l = 0; l < count; ++l) FillColumns(y, range, first + l, lda, A + l * dim * lda);
    const Accumulate accumulate = first == 0 ? Accumulate::kNo : Accumulate::kYes;
    SubtractProductAAt(columns, k, A, lda, C, lda, accumulate, columns == rows + 1 ? kRoom : 0);
    if (columns < rows)
      SubtractProductABt(rows + 1 - columns, columns, k, A + columns, lda, A, lda, C + columns, lda, accumulate);
  }
  AddBlocks(y, range, lda, C, S, b_S);
}

// ---- fixed sizes ------------------------------------------------------------------------------------------------

constexpr int kColumns = 24;  // of A at a time: A then stays in the first-level cache

CH5_INLINE void Subtract(const NarrowLanes& v, double* x) { *AsNarrow(x) -= v; }
CH5_INLINE void Subtract(const Lanes& v, double* x) { *AsLanes(x) -= v; }
CH5_INLINE void Subtract(const WideLanes& v, double* x) { *AsWide(x) -= v; }

// S (p×p) −= A Bᵀ over k columns; `Tile` columns of S at a time, as many as there are registers for. `Vector` is never
// wider than the processor's registers: GCC 12 takes longer ones apart through memory, which costs six times as much.
template <int P, typename Vector, int Tile, int First = 0>
CH5_INLINE void SubtractPair(const double* A, const double* B, int k, int p_size, double* S) {
  constexpr int kRows = Stride(kMost<P>), kTile = std::min(Tile, kMost<P> - First);
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
    if (First + c >= Pick<P>(p_size)) continue;
    double* column = S + (First + c) * kRows;
    CH5_UNROLL
    for (int r = 0; r < kWhole; ++r) Subtract(whole[c][r], column + r * kWidth);
    if constexpr (kRest) *AsLanes(column + kRows - kLanes) -= rest[c];
  }
  if constexpr (First + kTile < kMost<P>) {
    if (First + kTile < Pick<P>(p_size)) SubtractPair<P, Vector, Tile, First + kTile>(A, B, k, p_size, S);
  }
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

// b (p, without padding) −= A x over k columns.
template <int P>
CH5_INLINE void SubtractVector(const double* A, const double* x, int k, int p_size, double* b) {
  constexpr int kPerColumn = Stride(kMost<P>) / kLanes;
  Lanes sum[kPerColumn] = {};
  for (int p = 0; p < k; ++p, A += Stride(kMost<P>)) {
    CH5_UNROLL
    for (int i = 0; i < kPerColumn; ++i) sum[i] += AsLanes(A)[i] * x[p];
  }
  CH5_UNROLL
  for (int i = 0; i < kMost<P>; ++i) {
    if (i < Pick<P>(p_size)) b[i] -= sum[i / kLanes][i % kLanes];
  }
}

// The last rows of a column that has no padding; zeros take its place, or what follows if P is UpTo(n).
template <int P>
CH5_INLINE void LoadLastRows(const double* column, Lanes* rows) {
  constexpr int kFirst = Stride(kMost<P>) - kLanes;
  if constexpr (P < 0) return Load(column + kFirst, rows);
  const auto at = [&](int i) { return kFirst + i < P ? column[kFirst + i] : 0.0; };
  *rows = Lanes{at(0), at(1), at(2), at(3)};
}

// A (p×L) = H_pl G⁻ᵀ, written in the registers' widths in which it will be read: a wide read of narrow writes would wait.
template <int P, int L>
CH5_INLINE void Scale(const double* H_pl, const double* root, int p_size, double* A) {
  constexpr int kRows = Stride(kMost<P>), kWide = kRows / kPack;
  constexpr bool kNarrow = kRows % kPack != 0;
  const int p = Pick<P>(p_size);
  CH5_UNROLL
  for (int c = 0; c < L; ++c) {
    CH5_UNROLL
    for (int w = 0; w < kWide; ++w) {
      WideLanes rows, sum;
      Load(H_pl + w * kPack, &rows);
      sum = rows * root[c];
      CH5_UNROLL
      for (int m = 1; m <= c; ++m) {
        Load(H_pl + m * p + w * kPack, &rows);
        sum += rows * root[m * L + c];
      }
      *AsWide(A + c * kRows + w * kPack) = sum;
    }
    if constexpr (kNarrow) {
      Lanes rows, sum;
      LoadLastRows<P>(H_pl, &rows);
      sum = rows * root[c];
      CH5_UNROLL
      for (int m = 1; m <= c; ++m) {
        LoadLastRows<P>(H_pl + m * p, &rows);
        sum += rows * root[m * L + c];
      }
      *AsLanes(A + (c + 1) * kRows - kLanes) = sum;
    }
  }
}

template <int P, int L>
struct SubtractGroup {
  using Signature = void(const GroupSystem&, const PoseRange&, double* A, SymmetricBlockMatrix* S, double* b_S);
  static constexpr int kBlock = Stride(kMost<P>) * L, kBatch = kColumns / L;
  static constexpr int kPoseSize = kBatch * kBlock;  // from A_i to A_i+1

  template <SimdLevel kSimd>
  static CH5_INLINE void Run(const GroupSystem& y, const PoseRange& range, double* A, SymmetricBlockMatrix* S,
                             double* b_S) {
    const int n = static_cast<int>(y.poses_end - y.poses), p = y.poses->dim;
    const int begin = static_cast<int>(range.begin - y.poses), end = static_cast<int>(range.end - y.poses);
    for (int l = 0; l < y.num_landmarks; l += kBatch) {
      const int count = std::min(kBatch, y.num_landmarks - l);
      double rhs[kColumns];  // G⁻¹b
      FillColumns(y, l, count, begin, n, A, rhs);
      for (int j = begin; j < end; ++j) {
        const double* A_j = A + j * kPoseSize;
        const int* block = y.blocks + j * n - j * (j - 1) / 2;
        for (int i = j; i < n; ++i) SubtractFromBlock<kSimd>(A + i * kPoseSize, A_j, count, p, S->Values(*block++));
        SubtractVector<P>(A_j, rhs, count * L, p, b_S + y.poses[j].offset);
      }
    }
  }

 private:
  // A_i = [H_il G_l⁻ᵀ …] for the poses i ≥ begin, and G⁻¹b, of landmarks [first, first + count).
  static CH5_INLINE void FillColumns(const GroupSystem& y, int first, int count, int begin, int n, double* A,
                                     double* rhs) {
    const double* G_inverse = y.G_inverse + first * L * L;
    double expanded[BlockSize(P, L)];
    for (int k = 0; k < count; ++k, G_inverse += L * L) {
      const double* b = y.b + y.b_offset[first + k];
      for (int c = 0; c < L; ++c) {
        rhs[k * L + c] = G_inverse[c] * b[0];
        for (int m = 1; m <= c; ++m) rhs[k * L + c] += G_inverse[m * L + c] * b[m];
      }
      for (int i = begin; i < n; ++i) {
        const double* H_il = Block<P, L>(y.slots, y.slots.begin + (first + k) * n + i, expanded);
        PrefetchPageAhead<kMost<P> * L>(H_il);
        Scale<P, L>(H_il, G_inverse, y.poses->dim, A + i * kPoseSize + k * kBlock);
      }
    }
  }

  // S_ij −= A_i A_jᵀ over the columns of `count` landmarks.
  template <SimdLevel kSimd>
  static CH5_INLINE void SubtractFromBlock(const double* A_i, const double* A_j, int count, int p, double* S_ij) {
    constexpr int kRows = Stride(kMost<P>);  // 10 columns of 12 rows go by fives, 13 to 16 by eights
    if constexpr (P == 9 && kSimd == SimdLevel::kAvx512) {
      count == 1 ? SubtractPairAndRow<P, L>(A_i, A_j, L, S_ij) : SubtractPairAndRow<P, 0>(A_i, A_j, count * L, S_ij);
    } else if constexpr (kSimd == SimdLevel::kAvx512) {
      SubtractPair<P, WideLanes, (P > 0 ? 9 : kRows == 12 ? 5 : 8)>(A_i, A_j, count * L, p, S_ij);
    } else if constexpr (kSimd == SimdLevel::kAvx2) {
      SubtractPair<P, Lanes, kRows == 16 ? 3 : 4>(A_i, A_j, count * L, p, S_ij);
    } else {
      SubtractPair<P, NarrowLanes, 2>(A_i, A_j, count * L, p, S_ij);
    }
  }
};

// Its dense kernels choose for themselves.
template <>
struct SubtractGroup<Eigen::Dynamic, Eigen::Dynamic> {
  using Signature = SubtractGroup<6, 1>::Signature;
  template <SimdLevel>
  static void Run(const GroupSystem& y, const PoseRange& range, double* A, SymmetricBlockMatrix* S, double* b_S) {
    SubtractGeneralGroup(y, range, A, S, b_S);
  }
};

}  // namespace

SubtractGroupFunction SubtractGroupFor(const BlockSizes& sizes) { return DispatchByRegisters<SubtractGroup>(sizes); }

size_t GroupMemory(const BlockSizes& sizes, int poses, int rows) {
  if (sizes.AreFixed()) return static_cast<size_t>(poses) * kColumns * Stride(sizes.rows);
  const int lda = LeadingDimension(rows);
  return SizeOfA(lda) + static_cast<size_t>(lda) * lda + kOverread;
}

}  // namespace ch5::kernels
