#include "ch5_backend/sparse/steps/implicit_solver.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "ch5_backend/linear/pivot_rule.h"

namespace ch5 {
namespace {

using kernels::Pick;

// C (p×q) −= H Bᵀ;  H is p×l, B is q×l.
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

// Y (p×l) = H V;  H is p×l, V l×l without padding, symmetric.
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

// y (p, padded) −= H x;  H is p×l.
template <int P, int L>
CH5_INLINE void SubtractProductVector(const double* H, const double* x, int p_size, int l_size, double* y) {
  const int rows = Pick<P>(p_size), p = Stride(rows) / kLanes, l = Pick<L>(l_size);
  for (int k = 0; k < p; ++k) {
    Lanes sum = AsLanes(y)[k];
    for (int m = 0; m < l; ++m) sum -= AsLanes(H + m * rows)[k] * x[m];
    AsLanes(y)[k] = sum;
  }
}

// The same for a slot, whichever way its block is stored.
template <int P, int L>
CH5_INLINE void SubtractFromPose(const kernels::LandmarkSlots& slots, int slot, const double* x, int p_size, int l_size,
                                 double* y) {
  if constexpr (P != Eigen::Dynamic && L != Eigen::Dynamic) {
    using Factors = kernels::SlotFactors<P, L>;
    if (slots.factors)
      return Factors::SubtractProduct(slots.factors + static_cast<ptrdiff_t>(slot) * Factors::kSize, x, y);
  }
  SubtractProductVector<P, L>(slots.Block(slot), x, p_size, l_size, y);
}

// sums += C x over the landmarks [begin, end).
template <int P, int L>
struct MultiplyCouplingRange {
  using Signature = void(const Structure&, const Linearized&, const Eliminated&, int begin, int end, const double* x,
                         const int* padded_offset, double* sums);
  template <SimdLevel>
  static CH5_INLINE void Run(const Structure& s, const Linearized& y, const Eliminated& eliminated, int begin, int end,
                             const double* x, const int* padded_offset, double* sums) {
    thread_local Array<double> scratch;
    for (int l = begin; l < end; ++l) {
      const int dim = Pick<L>(s.landmark_dim[l]);
      scratch.assign(static_cast<size_t>(2 * dim), 0.0);
      double *w = scratch.data(), *v = w + dim;  // −Σ H_plᵀx_p, and (H_ll + λD)⁻¹ times it
      kernels::SumOverPoses<P, L>(y.Slots(s, l), dim, x, w);
      for (int m = 0; m < dim; ++m) w[m] = -w[m];
      kernels::AddSymmetric<L>(&eliminated.H_ll_inverse[s.landmark_block[l]], w, dim, v);
      const kernels::LandmarkSlots slots = y.Slots(s, l);
      for (int slot = slots.begin; slot < slots.end; ++slot) {
        const int p = s.slot_pose[slot];
        SubtractFromPose<P, L>(slots, slot, v, s.pose_dim[p], dim, sums + padded_offset[p]);
      }
    }
  }
};

// block (with padding), which holds B_jj, becomes S_jj = B_jj − C_jj on request;  b_S,j = b_j − Σ_l H_jl H_ll⁻¹ b_l.
template <int P, int L>
struct ReducePose {
  using Signature = void(const Structure&, const Linearized&, int j, bool subtract_coupling, int max_landmark_dim,
                         Eliminated*, double* block);
  static constexpr int kPrefetchDistance = 4;  // slots: one pose's blocks are scattered over memory

  template <SimdLevel>
  static CH5_INLINE void Run(const Structure& s, const Linearized& y, int j, bool subtract_coupling,
                             int max_landmark_dim, Eliminated* eliminated, double* block) {
    const int dim = Pick<P>(s.pose_dim[j]), stride = Stride(dim), end = s.pose_slots.begin[j + 1];
    thread_local AlignedVector scratch;
    scratch.assign(static_cast<size_t>(stride * (1 + Pick<L>(max_landmark_dim))), 0.0);
    double *b_j = scratch.data(), *Y = b_j + stride;  // Y = H_jl (H_ll + λD)⁻¹
    std::copy_n(y.b.data() + s.pose_offset[j], dim, b_j);
    alignas(64) double expanded[kernels::BlockSize(P, L)] = {};
    for (int k = s.pose_slots.begin[j]; k < end; ++k) {
      if (k + kPrefetchDistance < end) Prefetch(s, y, s.pose_slots.items[k + kPrefetchDistance]);
      const int slot = s.pose_slots.items[k], l = s.slot_landmark[slot], landmark_dim = Pick<L>(s.landmark_dim[l]);
      const kernels::LandmarkSlots slots = y.Slots(s, l);
      const double* H_ll_inverse_b = eliminated->H_ll_inverse_b.data() + s.landmark_offset[l] - s.ordering.dim_poses;
      SubtractFromPose<P, L>(slots, slot, H_ll_inverse_b, dim, landmark_dim, b_j);
      if (!subtract_coupling) continue;
      const double* H_jl = kernels::Block<P, L>(slots, slot, expanded);
      Multiply<P, L>(H_jl, &eliminated->H_ll_inverse[s.landmark_block[l]], dim, landmark_dim, Y);
      SubtractProduct<P, P, L>(H_jl, Y, dim, dim, landmark_dim, block);
    }
    std::copy_n(b_j, dim, eliminated->b_S.data() + s.pose_offset[j]);
  }

  static CH5_INLINE void Prefetch(const Structure& s, const Linearized& y, int slot) {
    if constexpr (P != Eigen::Dynamic && L != Eigen::Dynamic) {
      using Factors = kernels::SlotFactors<P, L>;
      const bool factored = !y.H_pl_factors.empty();
      const auto* block =
          factored ? reinterpret_cast<const char*>(&y.H_pl_factors[static_cast<size_t>(slot) * Factors::kSize])
                   : reinterpret_cast<const char*>(&y.H_pl[s.SlotBlock(slot)]);
      const int bytes = factored ? Factors::kSize * 4 : P * L * 8;
      for (int i = 0; i < bytes; i += 64) __builtin_prefetch(block + i);
    }
  }
};

int CommonDimension(const Array<int>& dims) {
  return !dims.empty() && std::equal(dims.begin() + 1, dims.end(), dims.begin()) ? dims[0] : Eigen::Dynamic;
}

}  // namespace

void ImplicitSchur::Prepare(const Structure& s, ThreadPool* pool) {
  structure_ = &s;
  pool_ = pool;
  sizes_ = {CommonDimension(s.pose_dim), CommonDimension(s.landmark_dim)};
  max_landmark_dim_ = s.landmark_dim.empty() ? 0 : *std::max_element(s.landmark_dim.begin(), s.landmark_dim.end());
  CutChunks();
  block_begin_.assign(1, 0);
  for (const int dim : s.pose_dim) block_begin_.push_back(block_begin_.back() + dim * dim);
  inverses_.assign(static_cast<size_t>(block_begin_.back()), 0.0);
  Cx_.assign(static_cast<size_t>(s.ordering.dim_poses), 0.0);
  damping_.setZero(s.ordering.dim_poses);
}

// Pieces of about equal work, which depend on the structure alone.
void ImplicitSchur::CutChunks() {
  constexpr int kSlots = 8192, kMost = 64;
  const Structure& s = *structure_;
  const int slots = static_cast<int>(s.slot_pose.size());
  const auto count = static_cast<size_t>(std::clamp(slots / kSlots, 1, kMost));
  Array<int> begin(1, 0);
  for (int l = 0; l < s.NumLandmarks(); ++l) {
    const double goal = static_cast<double>(slots) * static_cast<double>(begin.size()) / static_cast<double>(count);
    if (begin.size() < count && s.landmark_slots[l] >= goal) begin.push_back(l);
  }
  begin.push_back(s.NumLandmarks());
  chunks_.resize(begin.size() - 1);
  for (size_t k = 0; k < chunks_.size(); ++k) {
    Array<int> offset = NumberPosesOfLandmarks(s, begin[k], begin[k + 1]);
    int size = 0;
    for (size_t j = 0; j < offset.size(); ++j) {
      if (offset[j] >= 0) offset[j] = std::exchange(size, size + Stride(s.pose_dim[j]));
    }
    chunks_[k] = {begin[k], begin[k + 1], std::move(offset), AlignedVector(static_cast<size_t>(size))};
  }
}

bool ImplicitSchur::Damp(const Linearized& system, const DampingRule& rule, Preconditioner preconditioner,
                         Eliminated* eliminated) {
  system_ = &system;
  eliminated_ = eliminated;
  std::atomic<bool> ok{true};
  pool_->Run(structure_->NumPoses(), [&](int j) {
    if (!InvertDiagonalBlock(j, rule, preconditioner, eliminated)) ok = false;
  });
  return ok;
}

bool ImplicitSchur::InvertDiagonalBlock(int j, const DampingRule& rule, Preconditioner preconditioner,
                                        Eliminated* eliminated) {
  const Structure& s = *structure_;
  const int dim = s.pose_dim[j], stride = Stride(dim), offset = s.pose_offset[j];
  thread_local AlignedVector block;
  const double* H_jj = system_->H_pp.Values(system_->H_pp.ColumnBegin(j));
  block.assign(H_jj, H_jj + stride * dim);
  for (int c = 0; c < dim; ++c) {
    double& diagonal = block[static_cast<size_t>(c * stride + c)];
    damping_[offset + c] = rule.lambda * DampingEntry(rule.damping, diagonal);
    diagonal += damping_[offset + c];
    eliminated->damped_diagonal[offset + c] = diagonal;
  }
  const bool subtract_coupling = preconditioner == Preconditioner::kSchurJacobi;
  Dispatch<ReducePose>(sizes_)(s, *system_, j, subtract_coupling, max_landmark_dim_, eliminated, block.data());
  // What is left below the rounding of B is zero.
  const double rounding = PivotRounding(static_cast<int>(damping_.size()));
  bool good = true;
  thread_local Array<double> dense;
  dense.resize(static_cast<size_t>(dim * dim));
  for (int c = 0; c < dim; ++c) {
    good = good && block[static_cast<size_t>(c * stride + c)] > rounding * eliminated->damped_diagonal[offset + c];
    std::copy_n(&block[static_cast<size_t>(c * stride)], dim, &dense[static_cast<size_t>(c * dim)]);
  }
  double* inverse = &inverses_[static_cast<size_t>(block_begin_[j])];
  return kernels::InvertSymmetric<Eigen::Dynamic>(dense.data(), dim, inverse) && good;
}

// S x = (B − C) x.  Agarwal (2010)
void ImplicitSchur::Multiply(const VecX& x, VecX* y) {
  system_->H_pp.Multiply(x.data(), y->data());
  MultiplyCoupling(x.data(), Cx_.data());
  for (Eigen::Index i = 0; i < x.size(); ++i) (*y)[i] += damping_[i] * x[i] - Cx_[static_cast<size_t>(i)];
}

void ImplicitSchur::MultiplyCoupling(const double* x, double* y) {
  const Structure& s = *structure_;
  const auto multiply_range = Dispatch<MultiplyCouplingRange>(sizes_);
  pool_->Run(static_cast<int>(chunks_.size()), [&](int k) {
    Chunk& chunk = chunks_[k];
    std::fill(chunk.sums.begin(), chunk.sums.end(), 0.0);
    multiply_range(s, *system_, *eliminated_, chunk.begin, chunk.end, x, chunk.padded_offset.data(), chunk.sums.data());
  });
  ParallelFor(pool_, s.NumPoses(), 256, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) {
      double* y_j = y + s.pose_offset[j];
      std::fill_n(y_j, s.pose_dim[j], 0.0);
      for (const Chunk& chunk : chunks_) {
        if (chunk.padded_offset[j] < 0) continue;
        const double* sum = chunk.sums.data() + chunk.padded_offset[j];
        for (int i = 0; i < s.pose_dim[j]; ++i) y_j[i] += sum[i];
      }
    }
  });
}

void ImplicitSchur::Precondition(const VecX& r, VecX* z) const {
  const Structure& s = *structure_;
  z->setZero();
  for (size_t j = 0; j < s.poses.size(); ++j) {
    kernels::AddSymmetric<Eigen::Dynamic>(&inverses_[static_cast<size_t>(block_begin_[j])], r.data() + s.pose_offset[j],
                                          s.pose_dim[j], z->data() + s.pose_offset[j]);
  }
}

}  // namespace ch5
