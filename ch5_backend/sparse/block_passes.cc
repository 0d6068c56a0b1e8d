#include "ch5_backend/sparse/block_passes.h"

#include <algorithm>

#include "ch5_backend/sparse/edge_pack.h"
#include "ch5_backend/sparse/landmark_kernels.h"

namespace ch5 {
namespace {

using kernels::Pick;
using kernels::Scratch;

constexpr int ScratchSize(int rows, int columns) {
  return rows == Eigen::Dynamic || columns == Eigen::Dynamic ? Eigen::Dynamic : Stride(rows) * columns;
}

// What a landmark sums before it is put away.
struct LandmarkSums {
  double *H_ll, *b_l;  // H_ll with Stride(dim) numbers a column
};

// The bodies, each compiled for any processor and for AVX2 below.
template <int P, int L, typename Scalar, bool Wide>
struct Body : kernels::LandmarkKernels<P, L, Scalar> {
  static constexpr bool kFixed = P != Eigen::Dynamic && L != Eigen::Dynamic;

  static CH5_INLINE void LinearizeChunk(BlockSystem* system, int c) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    std::fill(y.sums[c].H_pp.begin(), y.sums[c].H_pp.end(), 0.0);
    std::fill(y.sums[c].b.begin(), y.sums[c].b.end(), 0.0);
    kernels::EdgePack pack(s.landmark_edges[s.chunk_begin[c]], s.landmark_edges[s.chunk_begin[c + 1]]);
    for (int l = s.chunk_begin[c]; l < s.chunk_begin[c + 1]; ++l) LinearizeLandmark(system, l, &pack, &y.sums[c]);
  }

  static CH5_INLINE void LinearizeLandmark(BlockSystem* system, int l, kernels::EdgePack* pack, PoseSums* poses) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    const int dim = Pick<L>(s.landmark_dim[l]);
    const bool packed = kFixed && y.packed.Active();
    if (!packed || !s.OneEdgePerSlot()) {
      Scalar* H_pm = BlocksOf<Scalar>(&y.H_pm);
      std::fill(H_pm + s.slot_block[s.landmark_slots[l]], H_pm + s.slot_block[s.landmark_slots[l + 1]], Scalar(0));
    }
    Scratch<ScratchSize(L, L)> H_scratch;
    Scratch<ScratchSize(L, 1), 1> b_scratch;
    const LandmarkSums sums{H_scratch.Zeros(Stride(dim) * dim), b_scratch.Zeros(Stride(dim))};
    for (int e = s.landmark_edges[l]; e < s.landmark_edges[l + 1]; ++e) {
      if constexpr (kFixed) {
        if (packed) {
          AddPackedEdge(system, e, pack, sums, poses);
          continue;
        }
      }
      PrefetchEdge(s.edges, e + kAhead);
      AddAnyEdge(system, e, dim, sums, poses);
    }
    for (int c = 0; c < dim; ++c) std::copy_n(sums.H_ll + c * Stride(dim), dim, &y.H_mm[s.landmark_block[l] + c * dim]);
    std::copy_n(sums.b_l, dim, y.b.data() + s.landmark_offset[l]);
  }

  static constexpr int kAhead = 6;  // edges

  static CH5_INLINE void AddPackedEdge(BlockSystem* system, int e, kernels::EdgePack* pack, const LandmarkSums& sums,
                                       PoseSums* poses) {
    constexpr int kR = PackedEdges::kRows;
    const BlockStructure& s = system->structure;
    const EdgeRecord& record = s.edges[e];
    const int lane = pack->LaneOf(system->packed, e), num_terms = record.terms_end - record.terms_begin;
    const EdgeTerm* terms = s.terms.data() + record.terms_begin;
    const auto jacobian = [&](int position) { return pack->Jacobian(system->packed, lane, position); };

    const double r[kR] = {pack->Residual(lane, 0), pack->Residual(lane, 1)};
    const double* A_l = jacobian(record.landmark_position);
    const kernels::Rows<kR, L, Wide> rows_l(A_l);
    rows_l.template AddTransposeProduct<L>(A_l, sums.H_ll);
    rows_l.SubtractTransposeVector(r, sums.b_l);
    const int* pair = s.pairs.data() + record.pairs;
    for (int i = 0; i < num_terms; ++i) {
      const double* A = jacobian(terms[i].position);
      const kernels::Rows<kR, P, Wide> rows(A);
      rows.template AddTransposeProductTight<L>(A_l, s.OneEdgePerSlot(),
                                                BlocksOf<Scalar>(&system->H_pm) + s.slot_block[terms[i].slot]);
      rows.SubtractTransposeVector(r, &poses->b[terms[i].block * system->pose_stride]);
      for (int j = 0; j < i; ++j) {
        rows.template AddTransposeProduct<P>(jacobian(terms[j].position),
                                             &poses->H_pp[system->H_pp.ValueBegin(*pair++)]);
      }
      rows.template AddTransposeProduct<P, true>(A, &poses->H_pp[system->H_pp.ValueBegin(*pair++)]);
    }
  }

  // Any other: its normal equations, block by block.
  static CH5_INLINE void AddAnyEdge(BlockSystem* system, int e, int dim, const LandmarkSums& sums, PoseSums* poses) {
    const BlockStructure& s = system->structure;
    const EdgeRecord& record = s.edges[e];
    record.edge->Linearize();
    thread_local AlignedVector memory;
    const int stride = record.width + 1;
    if (static_cast<int>(memory.size()) < (s.max_width + 1) * (s.max_width + 1)) {
      memory.resize(static_cast<size_t>((s.max_width + 1) * (s.max_width + 1)));
    }
    double* C = memory.data();
    EdgeProducts(s, e, &system->factors, C);
    const int row_l = record.width - dim;
    for (int c = 0; c < dim; ++c) {
      const double* column = C + (row_l + c) * stride;
      for (int r = c; r < dim; ++r) sums.H_ll[c * Stride(dim) + r] -= column[row_l + r];
      for (int r = c + 1; r < dim; ++r) sums.H_ll[r * Stride(dim) + c] -= column[row_l + r];
      sums.b_l[c] += column[record.width];
    }
    const int* pair = s.pairs.data() + record.pairs;
    for (int i = record.terms_begin; i < record.terms_end; ++i) {
      const EdgeTerm& a = s.terms[i];
      const int dim_a = s.pose_dim[a.block];
      Scalar* H_pl = BlocksOf<Scalar>(&system->H_pm) + s.slot_block[a.slot];
      double* b_p = &poses->b[a.block * system->pose_stride];
      for (int c = 0; c < dim_a; ++c) {
        const double* column = C + (a.column + c) * stride;
        for (int m = 0; m < dim; ++m) H_pl[m * dim_a + c] -= static_cast<Scalar>(column[row_l + m]);
        b_p[c] += column[record.width];
      }
      for (int j = record.terms_begin; j <= i; ++j) {
        const EdgeTerm& b = s.terms[j];
        double* H_ab = &poses->H_pp[system->H_pp.ValueBegin(*pair++)];
        SubtractBlock(C + b.column * stride + a.column, stride, dim_a, s.pose_dim[b.block], i == j, H_ab);
      }
    }
  }

  // H −= C, rows×columns; of a diagonal block C holds the lower half, H is full.
  static CH5_INLINE void SubtractBlock(const double* C, int stride, int rows, int columns, bool diagonal, double* H) {
    for (int c = 0; c < columns; ++c, C += stride) {
      for (int r = diagonal ? c : 0; r < rows; ++r) H[c * Stride(rows) + r] -= C[r];
      for (int r = c + 1; r < rows && diagonal; ++r) H[r * Stride(rows) + c] -= C[r];
    }
  }

  static CH5_INLINE void SumColumn(BlockSystem* system, int j) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    const int dim = s.pose_dim[j];
    double* b_j = y.b.data() + s.pose_offset[j];
    const ptrdiff_t begin = y.H_pp.ValueBegin(y.H_pp.ColumnBegin(j)), first = static_cast<ptrdiff_t>(j) * y.pose_stride;
    double *column = y.H_pp.AllValues() + begin, *end = y.H_pp.ColumnEnd(j);
    std::fill(column, end, 0.0);
    std::fill_n(b_j, dim, 0.0);
    for (const PoseSums& sums : y.sums) {
      const double *H = sums.H_pp.data() + begin, *b = sums.b.data() + first;
      for (ptrdiff_t k = 0; k < end - column; ++k) column[k] += H[k];
      for (int r = 0; r < dim; ++r) b_j[r] += b[r];
    }
    for (int c = 0; c < dim; ++c) {  // of the diagonal block only the upper half has been summed
      for (int r = c + 1; r < dim; ++r) column[c * Stride(dim) + r] = column[r * Stride(dim) + c];
    }
    for (int block = y.H_pp.ColumnBegin(j); block < y.H_pp.ColumnBegin(j + 1); ++block) {
      const int i = y.H_pp.Row(block);
      double* H_ij = y.H_pp.Values(block);
      for (int k = s.products_begin[block]; k < s.products_begin[block + 1]; ++k) {
        const Product& product = s.products[k];
        SubtractBlock(&y.products[product.values], product.stride, s.pose_dim[i], dim, i == j, H_ij);
        if (i != j) continue;
        for (int r = 0; r < dim; ++r) b_j[r] += y.products[product.rhs + r * product.stride];
      }
    }
  }
};

// The passes of one kind of processor.
#define CH5_PASSES(NAME, TARGET, WIDE)                                                                       \
  template <int P, int L, typename Scalar>                                                                   \
  struct NAME {                                                                                              \
    using B = Body<P, L, Scalar, WIDE>;                                                                      \
    TARGET static void Linearize(BlockSystem* y, int c) { B::LinearizeChunk(y, c); }                         \
    TARGET static void Sum(BlockSystem* y, int j) { B::SumColumn(y, j); }                                    \
    TARGET static bool Invert(BlockSystem* y, int begin, int end, const DampingRule& rule) {                 \
      return B::InvertLandmarks(y, begin, end, rule);                                                        \
    }                                                                                                        \
    TARGET static double Solve(const BlockSystem& y, int l, double* x) { return B::SolveLandmark(y, l, x); } \
    TARGET static void TimesPose(const BlockSystem& y, int j, const double* v, double* x) {                  \
      B::MultiplyPose(y, j, v, x);                                                                           \
    }                                                                                                        \
    TARGET static void TimesLandmark(const BlockSystem& y, int l, const double* v, double* x) {              \
      B::MultiplyLandmark(y, l, v, x);                                                                       \
    }                                                                                                        \
    static constexpr BlockPasses kTable{B::kFixed, Linearize, Sum, Invert, Solve, TimesPose, TimesLandmark}; \
  };

CH5_PASSES(Portable, , false)
CH5_PASSES(Avx2, CH5_WITH_AVX2, false)
CH5_PASSES(Avx512, CH5_WITH_AVX512, true)

template <int P, int L, typename Scalar>
const BlockPasses& Choose() {
  return HasAvx512() ? Avx512<P, L, Scalar>::kTable
         : HasAvx2() ? Avx2<P, L, Scalar>::kTable
                     : Portable<P, L, Scalar>::kTable;
}

template <typename Scalar>
const BlockPasses& Choose(int pose_dim, int landmark_dim) {
  if (pose_dim == 6 && landmark_dim == 1) return Choose<6, 1, Scalar>();
  if (pose_dim == 6 && landmark_dim == 3) return Choose<6, 3, Scalar>();
  if (pose_dim == 9 && landmark_dim == 3) return Choose<9, 3, Scalar>();
  return Choose<Eigen::Dynamic, Eigen::Dynamic, double>();
}

}  // namespace

const BlockPasses& PassesFor(int pose_dim, int landmark_dim, bool single_precision) {
  return single_precision ? Choose<float>(pose_dim, landmark_dim) : Choose<double>(pose_dim, landmark_dim);
}

}  // namespace ch5
