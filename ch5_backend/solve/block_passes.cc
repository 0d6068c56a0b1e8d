#include "ch5_backend/solve/block_passes.h"

#include <algorithm>

#include "ch5_backend/solve/edge_pack.h"

namespace ch5 {
namespace {

using kernels::Pick;

// Zeros for the length of a pass, aligned: on the stack where the size is known, else memory that each thread keeps,
// one piece for each `Index`.
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
constexpr int ScratchSize(int rows, int columns) {
  return rows == Eigen::Dynamic || columns == Eigen::Dynamic ? Eigen::Dynamic : Stride(rows) * columns;
}

// What a landmark sums before it is put away.
struct LandmarkSums {
  double *H_ll, *b_l;  // H_ll with Stride(dim) numbers a column
};

// The bodies, each compiled for any processor and for AVX2 below.
template <int P, int L>
struct Body {
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
    double* H_pm = y.H_pm.data();
    std::fill(H_pm + s.slot_block[s.landmark_slots[l]], H_pm + s.slot_block[s.landmark_slots[l + 1]], 0.0);
    Scratch<ScratchSize(L, L)> H_scratch;
    Scratch<ScratchSize(L, 1), 1> b_scratch;
    const LandmarkSums sums{H_scratch.Zeros(Stride(dim) * dim), b_scratch.Zeros(Stride(dim))};
    for (int e = s.landmark_edges[l]; e < s.landmark_edges[l + 1]; ++e) {
      if constexpr (kFixed) {
        if (y.packed.Active()) {
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
    const kernels::Rows<kR, L> rows_l(A_l);
    rows_l.template AddTransposeProduct<L>(A_l, sums.H_ll);
    rows_l.SubtractTransposeVector(r, sums.b_l);
    const int* pair = s.pairs.data() + record.pairs;
    for (int i = 0; i < num_terms; ++i) {
      const double* A = jacobian(terms[i].position);
      const kernels::Rows<kR, P> rows(A);
      rows.template AddTransposeProductTight<L>(A_l, &system->H_pm[s.slot_block[terms[i].slot]]);
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
      double *H_pl = &system->H_pm[s.slot_block[a.slot]], *b_p = &poses->b[a.block * system->pose_stride];
      for (int c = 0; c < dim_a; ++c) {
        const double* column = C + (a.column + c) * stride;
        for (int m = 0; m < dim; ++m) H_pl[m * dim_a + c] -= column[row_l + m];
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

  static CH5_INLINE bool InvertLandmarks(BlockSystem* system, int begin, int end, const DampingRule& rule) {
    if constexpr (kFixed) {
      bool good = true;
      for (int l = begin; l < end; l += kPack) good &= InvertPack(system, l, std::min(kPack, end - l), rule);
      return good;
    } else {
      for (int l = begin; l < end; ++l) {
        if (!InvertLandmark(system, l, rule)) return false;
      }
      return true;
    }
  }

  static CH5_INLINE void Damp(const BlockSystem& y, int l, int dim, const DampingRule& rule, double* damped) {
    std::copy_n(&y.H_mm[y.structure.landmark_block[l]], dim * dim, damped);
    for (int i = 0; i < dim; ++i) damped[i * dim + i] += rule.lambda * DampingEntry(rule.damping, damped[i * dim + i]);
  }

  // Landmarks [first, first + count), one in each lane; lanes without one hold copies of the last.
  static CH5_INLINE bool InvertPack(BlockSystem* system, int first, int count, const DampingRule& rule) {
    BlockSystem& y = *system;
    double damped[kPack][L * L];
    const double *A_of[kPack], *b_of[kPack];
    for (int k = 0; k < kPack; ++k) {
      const int l = std::min(k, count - 1);
      if (l == k) Damp(y, first + l, L, rule, damped[l]);
      A_of[k] = damped[l];
      b_of[k] = y.b.data() + y.structure.landmark_offset[first + l];
    }
    WideLanes A[L * L], V[L * L], b[L], product[L];
    GatherLanes<L * L>(A_of, A);
    GatherLanes<L>(b_of, b);
    if (!kernels::InvertSymmetric<L>(A, L, V)) return false;
    for (int r = 0; r < L; ++r) {
      product[r] = V[r] * b[0];
      for (int c = 1; c < L; ++c) product[r] += V[c * L + r] * b[c];
    }
    for (int k = 0; k < count; ++k) {
      const int block = y.structure.landmark_block[first + k], row = y.structure.landmark_offset[first + k];
      for (int i = 0; i < L * L; ++i) y.H_mm_inverse[block + i] = V[i][k];
      for (int i = 0; i < L * L; ++i) y.H_mm_root[block + i] = A[i][k];
      for (int i = 0; i < L; ++i) y.H_mm_inverse_b[row - y.structure.ordering.dim_poses + i] = product[i][k];
    }
    return true;
  }

  static bool InvertLandmark(BlockSystem* system, int l, const DampingRule& rule) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    const int dim = s.landmark_dim[l], first = s.landmark_offset[l];
    double *root = &y.H_mm_root[s.landmark_block[l]], *inverse = &y.H_mm_inverse[s.landmark_block[l]];
    Damp(y, l, dim, rule, root);
    if (!kernels::InvertSymmetric<L>(root, dim, inverse)) return false;
    double* product = y.H_mm_inverse_b.data() + first - s.ordering.dim_poses;
    std::fill_n(product, dim, 0.0);
    kernels::AddSymmetric<L>(inverse, y.b.data() + first, dim, product);
    return true;
  }

  // w += Σ_p H_plᵀ v_p
  static CH5_INLINE void SumOverPoses(const BlockSystem& y, int l, const double* v, double* w) {
    const BlockStructure& s = y.structure;
    const auto for_each_block = [&](const auto& take) {
      for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
        const int pose = s.slot_pose[slot];
        take(&y.H_pm[s.slot_block[slot]], v + s.pose_offset[pose], s.pose_dim[pose]);
      }
    };
    if constexpr (kFixed) {
      kernels::TransposedSum<P, L> sum;
      for_each_block([&](const double* W, const double* v_p, int) { sum.Add(W, v_p); });
      for (int m = 0; m < L; ++m) w[m] += sum.At(m);
    } else {
      const int dim = s.landmark_dim[l];
      for_each_block([&](const double* W, const double* v_p, int pose_dim) {
        kernels::AddTransposed<P, L>(W, v_p, pose_dim, dim, 1.0, w);
      });
    }
  }

  static CH5_INLINE double SolveLandmark(const BlockSystem& y, int l, double* delta_x) {
    const BlockStructure& s = y.structure;
    const int dim = Pick<L>(s.landmark_dim[l]), first = s.landmark_offset[l];
    Scratch<L == Eigen::Dynamic ? L : 2 * L> scratch;
    double* rest = scratch.Zeros(2 * dim);  // b_l − w
    double* H_delta = rest + dim;
    SumOverPoses(y, l, delta_x, rest);
    for (int i = 0; i < dim; ++i) rest[i] = y.b[first + i] - rest[i];
    double* delta_l = delta_x + first;
    std::fill_n(delta_l, dim, 0.0);
    kernels::AddSymmetric<L>(&y.H_mm_inverse[s.landmark_block[l]], rest, dim, delta_l);
    kernels::AddSymmetric<L>(&y.H_mm[s.landmark_block[l]], delta_l, dim, H_delta);
    double decrease = 0.0;
    for (int i = 0; i < dim; ++i) decrease += delta_l[i] * (rest[i] - 0.5 * H_delta[i]);
    return decrease;
  }

  static CH5_INLINE void MultiplyPose(const BlockSystem& y, int j, const double* v, double* product) {
    const BlockStructure& s = y.structure;
    const int dim = Pick<P>(s.pose_dim[j]);
    for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
      const int slot = s.pose_slots[k], l = s.slot_landmark[slot];
      const double* W = &y.H_pm[s.slot_block[slot]];
      for (int m = 0; m < Pick<L>(s.landmark_dim[l]); ++m, W += dim) {
        for (int i = 0; i < dim; ++i) product[s.pose_offset[j] + i] += W[i] * v[s.landmark_offset[l] + m];
      }
    }
  }

  static CH5_INLINE void MultiplyLandmark(const BlockSystem& y, int l, const double* v, double* product) {
    const BlockStructure& s = y.structure;
    const int dim = Pick<L>(s.landmark_dim[l]);
    double* product_l = product + s.landmark_offset[l];
    kernels::AddSymmetric<L>(&y.H_mm[s.landmark_block[l]], v + s.landmark_offset[l], dim, product_l);
    SumOverPoses(y, l, v, product_l);
  }
};

template <int P, int L>
struct Portable {
  using B = Body<P, L>;
  static void Linearize(BlockSystem* y, int c) { B::LinearizeChunk(y, c); }
  static void Sum(BlockSystem* y, int j) { B::SumColumn(y, j); }
  static bool Invert(BlockSystem* y, int begin, int end, const DampingRule& rule) {
    return B::InvertLandmarks(y, begin, end, rule);
  }
  static double Solve(const BlockSystem& y, int l, double* x) { return B::SolveLandmark(y, l, x); }
  static void TimesPose(const BlockSystem& y, int j, const double* v, double* x) { B::MultiplyPose(y, j, v, x); }
  static void TimesLandmark(const BlockSystem& y, int l, const double* v, double* x) {
    B::MultiplyLandmark(y, l, v, x);
  }
};

template <int P, int L>
struct Avx2 {
  using B = Body<P, L>;
  CH5_WITH_AVX2 static void Linearize(BlockSystem* y, int c) { B::LinearizeChunk(y, c); }
  CH5_WITH_AVX2 static void Sum(BlockSystem* y, int j) { B::SumColumn(y, j); }
  CH5_WITH_AVX2 static bool Invert(BlockSystem* y, int begin, int end, const DampingRule& rule) {
    return B::InvertLandmarks(y, begin, end, rule);
  }
  CH5_WITH_AVX2 static double Solve(const BlockSystem& y, int l, double* x) { return B::SolveLandmark(y, l, x); }
  CH5_WITH_AVX2 static void TimesPose(const BlockSystem& y, int j, const double* v, double* x) {
    B::MultiplyPose(y, j, v, x);
  }
  CH5_WITH_AVX2 static void TimesLandmark(const BlockSystem& y, int l, const double* v, double* x) {
    B::MultiplyLandmark(y, l, v, x);
  }
};

template <typename Set>
constexpr BlockPasses Table() {
  return {Set::B::kFixed, Set::Linearize, Set::Sum, Set::Invert, Set::Solve, Set::TimesPose, Set::TimesLandmark};
}

template <int P, int L>
const BlockPasses& Choose() {
  static constexpr BlockPasses portable = Table<Portable<P, L>>(), avx2 = Table<Avx2<P, L>>();
  return HasAvx2() ? avx2 : portable;
}

}  // namespace

const BlockPasses& PassesFor(int pose_dim, int landmark_dim) {
  if (pose_dim == 6 && landmark_dim == 1) return Choose<6, 1>();
  if (pose_dim == 6 && landmark_dim == 3) return Choose<6, 3>();
  if (pose_dim == 9 && landmark_dim == 3) return Choose<9, 3>();
  return Choose<Eigen::Dynamic, Eigen::Dynamic>();
}

}  // namespace ch5
