#include "ch5_backend/solve/block_passes.h"

#include <algorithm>

#include "ch5_backend/solve/block_kernels.h"
#include "ch5_backend/solve/linear_parts.h"

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

// The bodies, each compiled for any processor and for AVX2 below.
template <int P, int L>
struct Body {
  static CH5_INLINE void LinearizeLandmark(BlockSystem* system, int l) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    const int dim = Pick<L>(s.landmark_dim[l]);
    double* H_pm = y.H_pm.data();
    std::fill(H_pm + s.slot_block[s.landmark_slots[l]], H_pm + s.slot_block[s.landmark_slots[l + 1]], 0.0);
    Scratch<ScratchSize(L, L)> H_scratch;
    Scratch<ScratchSize(L, 1), 1> b_scratch;
    double* H_ll = H_scratch.Zeros(Stride(dim) * dim);
    double* b_l = b_scratch.Zeros(Stride(dim));
    for (int e = s.landmark_edges[l]; e < s.landmark_edges[l + 1]; ++e) {
      const EdgeRecord& record = s.edges[e];
      record.edge->Linearize();
      const double scale = ScalarWhitening(*record.edge);
      if (P != Eigen::Dynamic && L != Eigen::Dynamic && record.rows == 2 && scale >= 0.0) {
        AddPlainEdge(system, record, scale, H_ll, b_l);
      } else {
        WriteLinearParts(s, record, y.linear.data());
        AddEdge(system, record, dim, H_ll, b_l);
      }
    }
    for (int c = 0; c < dim; ++c) std::copy_n(H_ll + c * Stride(dim), dim, &y.H_mm[s.landmark_block[l] + c * dim]);
    std::copy_n(b_l, dim, y.b.data() + s.landmark_offset[l]);
  }

  static CH5_INLINE void AddEdge(BlockSystem* system, const EdgeRecord& record, int dim, double* H_ll, double* b_l) {
    const BlockStructure& s = system->structure;
    const double* linear = system->linear.data();
    const double* J_l = linear + record.landmark.jacobian;
    kernels::AddTransposeProduct<L, L>(J_l, J_l, record.rows, dim, dim, H_ll);
    kernels::SubtractTransposeVector<L>(J_l, linear + record.residual, record.rows, dim, b_l);
    for (int t = record.terms_begin; t < record.terms_end; ++t) {
      const EdgeTerm& term = s.terms[t];
      kernels::AddTransposeProduct<P, L>(linear + term.jacobian, J_l, record.rows, s.pose_dim[term.block], dim,
                                         &system->H_pm[s.slot_block[term.slot]]);
    }
  }

  // WriteLinearParts and AddEdge in one for the most frequent kind of edge: two rows, J̃ = scale·J, sizes known.
  static CH5_INLINE void AddPlainEdge(BlockSystem* system, const EdgeRecord& record, double scale, double* H_ll,
                                      double* b_l) {
    if constexpr (P != Eigen::Dynamic && L != Eigen::Dynamic) {
      constexpr int R = 2;
      const BlockStructure& s = system->structure;
      double* linear = system->linear.data();
      const Edge& edge = *record.edge;
      const double *r = edge.Residual().data(),
                   *J_l = edge.Jacobian(static_cast<size_t>(record.landmark.position)).data();
      for (int k = 0; k < R; ++k) linear[record.residual + k] = scale * r[k];
      kernels::Rows<R, L> A_l;
      A_l.Load(scale, J_l);
      A_l.Store(linear + record.landmark.jacobian);
      A_l.template AddTransposeProduct<L>(J_l, 1, R, scale, H_ll);
      A_l.SubtractTransposeVector(r, scale, b_l);
      for (int t = record.terms_begin; t < record.terms_end; ++t) {
        const EdgeTerm& term = s.terms[t];
        kernels::Rows<R, P> A;
        A.Load(scale, edge.Jacobian(static_cast<size_t>(term.position)).data());
        A.Store(linear + term.jacobian);
        A.template AddTransposeProduct<L>(J_l, 1, R, scale, &system->H_pm[s.slot_block[term.slot]]);
      }
    }
  }

  static CH5_INLINE void SumColumn(BlockSystem* system, int j) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    const int dim = Pick<P>(s.pose_dim[j]);
    Scratch<ScratchSize(P, 1)> scratch;
    double* b_j = scratch.Zeros(Stride(dim));
    for (int block = y.H_pp.ColumnBegin(j); block < y.H_pp.ColumnBegin(j + 1); ++block) {
      const int rows = Pick<P>(s.pose_dim[y.H_pp.Row(block)]);
      double* H_ij = y.H_pp.Values(block);
      std::fill_n(H_ij, Stride(rows) * dim, 0.0);
      const Product* begin = s.products.data() + s.products_begin[block];
      const Product* end = s.products.data() + s.products_begin[block + 1];
      double* b = block == y.H_pp.ColumnBegin(j) ? b_j : nullptr;
      for (const Product* product = begin; product != end; ++product) {
        if (end - product > kAhead) Prefetch(y, product[kAhead], rows);
        AddProduct(y, *product, rows, dim, H_ij, b);
      }
    }
    std::copy_n(b_j, dim, y.b.data() + s.pose_offset[j]);
  }

  // The linear parts of one pose are scattered over memory, where no processor guesses them.
  static constexpr int kAhead = 6;
  static CH5_INLINE void Prefetch(const BlockSystem& y, const Product& product, int rows) {
    const double* A = y.linear.data() + product.jacobian_a;
    for (int i = 0; i < 2 * Stride(rows); i += 8) __builtin_prefetch(A + i);
  }

  static CH5_INLINE void AddProduct(const BlockSystem& y, const Product& product, int rows, int dim, double* H_ij,
                                    double* b_j) {
    const double *A = &y.linear[product.jacobian_a], *B = &y.linear[product.jacobian_b];
    const double* r = &y.linear[product.residual];
    if constexpr (P != Eigen::Dynamic) {
      if (product.rows == 2) {
        kernels::Rows<2, P> A_rows;
        A_rows.LoadStored(A);
        A_rows.template AddTransposeProduct<P>(B, Stride(P), 1, 1.0, H_ij);
        if (b_j) A_rows.SubtractTransposeVector(r, 1.0, b_j);
        return;
      }
    }
    kernels::AddTransposeProduct<P, P>(A, B, product.rows, rows, dim, H_ij);
    if (b_j) kernels::SubtractTransposeVector<P>(A, r, product.rows, dim, b_j);
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
    double* product = y.H_mm_inverse_b.data() + first - s.ordering.dim_poses;
    std::fill_n(product, dim, 0.0);
    kernels::AddSymmetric<L>(inverse, y.b.data() + first, dim, product);
    return true;
  }

  static CH5_INLINE void SchurColumn(BlockSystem* system, int j, const DampingRule& rule) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    const int dim = Pick<P>(s.pose_dim[j]), offset = s.pose_offset[j];
    thread_local std::vector<double*> block_of_row;  // S's block (i, j)
    BeginSchurColumn(system, j, rule, &block_of_row);

    Scratch<ScratchSize(P, 1)> b_scratch;
    Scratch<ScratchSize(P, L), 1> Y_scratch;
    double* b_j = b_scratch.Zeros(Stride(dim));
    std::copy_n(y.b.data() + offset, dim, b_j);
    for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
      const int slot = s.pose_slots[k], l = s.slot_landmark[slot], landmark_dim = Pick<L>(s.landmark_dim[l]);
      const double* W_j = &y.H_pm[s.slot_block[slot]];
      double* Y = Y_scratch.Zeros(Stride(dim) * landmark_dim);  // H_jl H_ll⁻¹
      kernels::Multiply<P, L>(W_j, &y.H_mm_inverse[s.landmark_block[l]], dim, landmark_dim, Y);
      kernels::SubtractProductVector<P, L>(W_j, y.H_mm_inverse_b.data() + s.landmark_offset[l] - s.ordering.dim_poses,
                                           dim, landmark_dim, b_j);
      for (int other = slot; other < s.landmark_slots[l + 1]; ++other) {
        const int i = s.slot_pose[other];
        kernels::SubtractProduct<P, P, L>(&y.H_pm[s.slot_block[other]], Y, s.pose_dim[i], dim, landmark_dim,
                                          block_of_row[i]);
      }
    }
    std::copy_n(b_j, dim, y.b_schur.data() + offset);
  }

  // Column j of H_pp + λD, and where its blocks are.
  static CH5_INLINE void BeginSchurColumn(BlockSystem* system, int j, const DampingRule& rule,
                                          std::vector<double*>* block_of_row) {
    BlockSystem& y = *system;
    const BlockStructure& s = y.structure;
    const int dim = Pick<P>(s.pose_dim[j]);
    if (block_of_row->size() < s.poses.size()) block_of_row->resize(s.poses.size());
    for (int block = y.S.ColumnBegin(j); block < y.S.ColumnBegin(j + 1); ++block) {
      (*block_of_row)[y.S.Row(block)] = y.S.Values(block);
    }
    double* column = y.S.Values(y.S.ColumnBegin(j));
    std::fill(column, y.S.ColumnEnd(j), 0.0);
    for (int block = y.H_pp.ColumnBegin(j); block < y.H_pp.ColumnBegin(j + 1); ++block) {
      const int i = y.H_pp.Row(block);
      std::copy_n(y.H_pp.Values(block), Stride(Pick<P>(s.pose_dim[i])) * dim, (*block_of_row)[i]);
    }
    for (int c = 0; c < dim; ++c) {
      double& diagonal = column[c * Stride(dim) + c];
      diagonal += rule.lambda * DampingEntry(rule.damping, diagonal);
      y.scale[s.pose_offset[j] + c] = diagonal;
    }
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
      for (int m = 0; m < Pick<L>(s.landmark_dim[l]); ++m, W += Stride(dim)) {
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
  static void Linearize(BlockSystem* y, int l) { B::LinearizeLandmark(y, l); }
  static void Sum(BlockSystem* y, int j) { B::SumColumn(y, j); }
  static bool Invert(BlockSystem* y, int l, const DampingRule& rule) { return B::InvertLandmark(y, l, rule); }
  static void Schur(BlockSystem* y, int j, const DampingRule& rule) { B::SchurColumn(y, j, rule); }
  static double Solve(const BlockSystem& y, int l, double* x) { return B::SolveLandmark(y, l, x); }
  static void TimesPose(const BlockSystem& y, int j, const double* v, double* x) { B::MultiplyPose(y, j, v, x); }
  static void TimesLandmark(const BlockSystem& y, int l, const double* v, double* x) {
    B::MultiplyLandmark(y, l, v, x);
  }
};

template <int P, int L>
struct Avx2 {
  using B = Body<P, L>;
  CH5_WITH_AVX2 static void Linearize(BlockSystem* y, int l) { B::LinearizeLandmark(y, l); }
  CH5_WITH_AVX2 static void Sum(BlockSystem* y, int j) { B::SumColumn(y, j); }
  CH5_WITH_AVX2 static bool Invert(BlockSystem* y, int l, const DampingRule& rule) {
    return B::InvertLandmark(y, l, rule);
  }
  CH5_WITH_AVX2 static void Schur(BlockSystem* y, int j, const DampingRule& rule) { B::SchurColumn(y, j, rule); }
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
  return {Set::Linearize, Set::Sum, Set::Invert, Set::Schur, Set::Solve, Set::TimesPose, Set::TimesLandmark};
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
