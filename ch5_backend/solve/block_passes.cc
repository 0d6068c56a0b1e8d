#include "ch5_backend/solve/block_passes.h"

#include <algorithm>

#include "ch5_backend/solve/block_kernels.h"

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
    Pack pack;
    pack.next = s.landmark_edges[s.chunk_begin[c]];
    pack.end = s.landmark_edges[s.chunk_begin[c + 1]];
    for (int l = s.chunk_begin[c]; l < s.chunk_begin[c + 1]; ++l) LinearizeLandmark(system, l, &pack, &y.sums[c]);
  }

  // The edges of a chunk come eight at a time, whatever their landmarks.
  struct Pack {
    alignas(64) double r[PackedEdges::kRows * kPack];
    alignas(64) double J[PackedEdges::kRows * PackedEdges::kMostColumns * kPack];
    int first, next, end;  // edges
  };

  static CH5_INLINE void LinearizeLandmark(BlockSystem* system, int l, Pack* pack, PoseSums* poses) {
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
          if (e == pack->next) LinearizePack(y.packed, pack);
          AddPackedEdge(system, e, *pack, sums, poses);
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

  // r̃ and J̃ of the next edges.
  static CH5_INLINE void LinearizePack(const PackedEdges& edges, Pack* pack) {
    const int count = std::min(kPack, pack->end - pack->next);
    pack->first = pack->next;
    pack->next += count;
    edges.Linearize(pack->first, count, pack->r, pack->J);
    if (edges.Unweighted()) return;
    alignas(64) double M[3][kPack] = {};  // M_00, M_01 = M_10, M_11
    for (int k = 0; k < count; ++k) {
      double r[2] = {pack->r[k], pack->r[kPack + k]};
      const WhiteRows white(edges.Information(pack->first + k), edges.Loss(pack->first + k), r);
      for (int i = 0; i < 2; ++i) pack->r[i * kPack + k] = white.r[i];
      for (int i = 0; i < 3; ++i) M[i][k] = white.M[i / 2][(i + 1) / 2];
    }
    const auto* m = reinterpret_cast<const WideLanes*>(M);
    auto* J = reinterpret_cast<WideLanes*>(pack->J);
    for (int i = 0; i < edges.NumJacobians(); i += 2) {
      const WideLanes upper = J[i], lower = J[i + 1];
      J[i] = m[0] * upper + m[1] * lower;
      J[i + 1] = m[1] * upper + m[2] * lower;
    }
  }

  static CH5_INLINE void AddPackedEdge(BlockSystem* system, int e, const Pack& pack, const LandmarkSums& sums,
                                       PoseSums* poses) {
    constexpr int kR = PackedEdges::kRows, kMostTerms = PackedEdges::kMostColumns / P;
    const BlockStructure& s = system->structure;
    const EdgeRecord& record = s.edges[e];
    const int lane = e - pack.first, num_terms = record.terms_end - record.terms_begin;
    const EdgeTerm* terms = s.terms.data() + record.terms_begin;
    const auto jacobian = [&](int position) { return pack.J + system->packed.JacobianBegin(position) * kPack; };

    const double r[kR] = {pack.r[lane], pack.r[kPack + lane]};
    kernels::Rows<kR, L> A_l;
    alignas(32) double A_l_stored[kR * Stride(L)], A_stored[kMostTerms][kR * Stride(P)];
    A_l.LoadLane(jacobian(record.landmark.position), lane);
    A_l.Store(A_l_stored);
    A_l.template AddTransposeProduct<L>(A_l_stored, sums.H_ll);
    A_l.SubtractTransposeVector(r, sums.b_l);
    const int* pair = s.pairs.data() + record.pairs;
    for (int i = 0; i < num_terms; ++i) {
      const EdgeTerm& term = terms[i];
      kernels::Rows<kR, P> A;
      A.LoadLane(jacobian(term.position), lane);
      A.Store(A_stored[i]);
      A.template AddTransposeProductTight<L>(A_l_stored, &system->H_pm[s.slot_block[term.slot]]);
      A.SubtractTransposeVector(r, &poses->b[term.block * system->pose_stride]);
      for (int j = 0; j < i; ++j) {
        A.template AddTransposeProduct<P>(A_stored[j], &poses->H_pp[system->H_pp.ValueBegin(*pair++)]);
      }
      A.template AddTransposeProduct<P, true>(A_stored[i], &poses->H_pp[system->H_pp.ValueBegin(*pair++)]);
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
    const int row_l = record.landmark.column;
    for (int c = 0; c < dim; ++c) {
      const double* column = C + (row_l + c) * stride;
      for (int r = c; r < dim; ++r) sums.H_ll[c * Stride(dim) + r] -= column[row_l + r];
      for (int r = c + 1; r < dim; ++r) sums.H_ll[r * Stride(dim) + c] -= column[row_l + r];
      sums.b_l[c] += column[record.width];
    }
    const int* pair = s.pairs.data() + record.pairs;
    for (int i = record.terms_begin; i < record.terms_end; ++i) {
      const EdgeTerm& a = s.terms[i];
      double *H_pl = &system->H_pm[s.slot_block[a.slot]], *b_p = &poses->b[a.block * system->pose_stride];
      for (int c = 0; c < a.dim; ++c) {
        const double* column = C + (a.column + c) * stride;
        for (int m = 0; m < dim; ++m) H_pl[m * a.dim + c] -= column[row_l + m];
        b_p[c] += column[record.width];
      }
      for (int j = record.terms_begin; j <= i; ++j) {
        const EdgeTerm& b = s.terms[j];
        double* H_ab = &poses->H_pp[system->H_pp.ValueBegin(*pair++)];
        SubtractBlock(C + b.column * stride + a.column, stride, a.dim, b.dim, i == j, H_ab);
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
    for (int c = 0; c < dim; ++c) {  // of the diagonal block only the lower half has been summed
      for (int r = c + 1; r < dim; ++r) column[r * Stride(dim) + c] = column[c * Stride(dim) + r];
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

  static CH5_INLINE bool InvertLandmark(BlockSystem* system, int l, const DampingRule& rule) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    const int dim = Pick<L>(s.landmark_dim[l]), first = s.landmark_offset[l];
    Scratch<L == Eigen::Dynamic ? L : L * L> scratch;
    double* damped = scratch.Zeros(dim * dim);
    double* inverse = &y.H_mm_inverse[s.landmark_block[l]];
    std::copy_n(&y.H_mm[s.landmark_block[l]], dim * dim, damped);
    for (int i = 0; i < dim; ++i) damped[i * dim + i] += rule.lambda * DampingEntry(rule.damping, damped[i * dim + i]);
    if (!kernels::InvertSymmetric<L>(damped, dim, inverse)) return false;
    std::copy_n(damped, dim * dim, &y.H_mm_root[s.landmark_block[l]]);
    double* product = y.H_mm_inverse_b.data() + first - s.ordering.dim_poses;
    std::fill_n(product, dim, 0.0);
    kernels::AddSymmetric<L>(inverse, y.b.data() + first, dim, product);
    return true;
  }

  static CH5_INLINE double SolveLandmark(const BlockSystem& y, int l, double* delta_x) {
    const BlockStructure& s = y.structure;
    const int dim = Pick<L>(s.landmark_dim[l]), first = s.landmark_offset[l];
    Scratch<L == Eigen::Dynamic ? L : 2 * L> scratch;
    double* rest = scratch.Zeros(2 * dim);  // b_l − w
    double* H_delta = rest + dim;
    std::copy_n(y.b.data() + first, dim, rest);
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const int pose = s.slot_pose[slot];
      kernels::AddTransposed<P, L>(&y.H_pm[s.slot_block[slot]], delta_x + s.pose_offset[pose], s.pose_dim[pose], dim,
                                   -1.0, rest);
    }
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
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const int pose = s.slot_pose[slot];
      kernels::AddTransposed<P, L>(&y.H_pm[s.slot_block[slot]], v + s.pose_offset[pose], s.pose_dim[pose], dim, 1.0,
                                   product_l);
    }
  }
};

template <int P, int L>
struct Portable {
  using B = Body<P, L>;
  static void Linearize(BlockSystem* y, int c) { B::LinearizeChunk(y, c); }
  static void Sum(BlockSystem* y, int j) { B::SumColumn(y, j); }
  static bool Invert(BlockSystem* y, int l, const DampingRule& rule) { return B::InvertLandmark(y, l, rule); }
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
  CH5_WITH_AVX2 static bool Invert(BlockSystem* y, int l, const DampingRule& rule) {
    return B::InvertLandmark(y, l, rule);
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
