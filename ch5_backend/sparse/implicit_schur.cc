#include "ch5_backend/sparse/implicit_schur.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "ch5_backend/sparse/block_kernels.h"

namespace ch5 {

struct ImplicitSchur::PoseTask {
  BlockSystem* system;
  int pose;
  bool subtract_coupling;
  int max_landmark_dim;
};

// block (with padding), which holds B_jj, becomes S_jj = B_jj − Σ_l E_jl C_l⁻¹ E_jlᵀ if that is asked for;
// b_s,j = b_j − Σ_l E_jl C_l⁻¹ b_l.  P and L as in block_passes.h.
template <int P, int L>
struct ImplicitSchur::Reduce {
  static CH5_INLINE void Body(const PoseTask& task, double* block) {
    BlockSystem& y = *task.system;
    const BlockStructure& s = y.structure;
    const int j = task.pose, dim = kernels::Pick<P>(s.pose_dim[j]), stride = Stride(dim);
    thread_local AlignedVector scratch;
    scratch.assign(static_cast<size_t>(stride * (1 + kernels::Pick<L>(task.max_landmark_dim))), 0.0);
    double *b_j = scratch.data(), *Y = b_j + stride;  // Y = E_jl C_l⁻¹
    std::copy_n(y.b.data() + s.pose_offset[j], dim, b_j);
    for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
      if (k + kAhead < s.pose_slots_begin[j + 1]) Prefetch(&y.H_pm.doubles[s.slot_block[s.pose_slots[k + kAhead]]]);
      const int slot = s.pose_slots[k], l = s.slot_landmark[slot], landmark_dim = kernels::Pick<L>(s.landmark_dim[l]);
      const double* E = &y.H_pm.doubles[s.slot_block[slot]];
      kernels::SubtractProductVector<P, L>(E, y.H_mm_inverse_b.data() + s.landmark_offset[l] - s.ordering.dim_poses,
                                           dim, landmark_dim, b_j);
      if (!task.subtract_coupling) continue;
      kernels::Multiply<P, L>(E, &y.H_mm_inverse[s.landmark_block[l]], dim, landmark_dim, Y);
      kernels::SubtractProduct<P, P, L>(E, Y, dim, dim, landmark_dim, block);
    }
    std::copy_n(b_j, dim, y.b_schur.data() + s.pose_offset[j]);
  }
  // One pose's blocks are scattered over memory, where no processor guesses them.
  static constexpr int kAhead = 4;
  static CH5_INLINE void Prefetch(const double* E) {
    for (int i = 0; i < (P > 0 && L > 0 ? P * L : 0); i += 8) __builtin_prefetch(E + i);
  }
  static void Portable(const PoseTask& task, double* block) { Body(task, block); }
  CH5_WITH_AVX2 static void Avx2(const PoseTask& task, double* block) { Body(task, block); }
  static ReducePose Choose() { return HasAvx2() ? Avx2 : Portable; }
};

ImplicitSchur::ReducePose ImplicitSchur::ReduceFor(int pose_dim, int landmark_dim) {
  if (pose_dim == 6 && landmark_dim == 1) return Reduce<6, 1>::Choose();
  if (pose_dim == 6 && landmark_dim == 3) return Reduce<6, 3>::Choose();
  if (pose_dim == 9 && landmark_dim == 3) return Reduce<9, 3>::Choose();
  return Reduce<Eigen::Dynamic, Eigen::Dynamic>::Choose();
}

ImplicitSchur::ImplicitSchur(int pose_dim, int landmark_dim)
    : coupling_(pose_dim, landmark_dim), reduce_(ReduceFor(pose_dim, landmark_dim)) {}

void ImplicitSchur::Prepare(BlockSystem* system, ThreadPool* pool) {
  system_ = system;
  pool_ = pool;
  coupling_.Prepare(*system);
  const BlockStructure& s = system->structure;
  block_begin_.assign(1, 0);
  for (const int dim : s.pose_dim) block_begin_.push_back(block_begin_.back() + dim * dim);
  inverses_.assign(static_cast<size_t>(block_begin_.back()), 0.0);
  Wx_.assign(static_cast<size_t>(s.ordering.dim_poses), 0.0);
  damping_.setZero(s.ordering.dim_poses);
  max_landmark_dim_ = 0;
  for (const int dim : s.landmark_dim) max_landmark_dim_ = std::max(max_landmark_dim_, dim);
}

bool ImplicitSchur::Damp(const DampingRule& rule, Preconditioner preconditioner) {
  BlockSystem& y = *system_;
  const BlockStructure& s = y.structure;
  std::atomic<bool> ok{true};
  pool_->Run(static_cast<int>(s.poses.size()), [&](int j) {
    const int dim = s.pose_dim[j], stride = Stride(dim), offset = s.pose_offset[j];
    thread_local AlignedVector block;
    const double* H_jj = y.H_pp.Values(y.H_pp.ColumnBegin(j));
    block.assign(H_jj, H_jj + stride * dim);
    for (int c = 0; c < dim; ++c) {
      double& diagonal = block[static_cast<size_t>(c * stride + c)];
      damping_[offset + c] = rule.lambda * DampingEntry(rule.damping, diagonal);
      diagonal += damping_[offset + c];
      y.scale[offset + c] = diagonal;
    }
    reduce_({system_, j, preconditioner == Preconditioner::kSchurJacobi, max_landmark_dim_}, block.data());
    // What is left below the rounding of B is zero, as for a pivot in reduced_solver.h.
    const double rounding = 8.0 * static_cast<double>(damping_.size()) * std::numeric_limits<double>::epsilon();
    double* inverse = &inverses_[static_cast<size_t>(block_begin_[j])];
    thread_local std::vector<double> dense;
    dense.resize(static_cast<size_t>(dim * dim));
    for (int c = 0; c < dim; ++c) {
      if (!(block[static_cast<size_t>(c * stride + c)] > rounding * y.scale[offset + c])) ok = false;
      std::copy_n(&block[static_cast<size_t>(c * stride)], dim, &dense[static_cast<size_t>(c * dim)]);
    }
    if (!kernels::InvertSymmetric<Eigen::Dynamic>(dense.data(), dim, inverse)) ok = false;
  });
  return ok;
}

void ImplicitSchur::Multiply(const VecX& x, VecX* y) {
  system_->H_pp.Multiply(x.data(), y->data());
  coupling_.Multiply(*system_, x.data(), Wx_.data(), pool_);
  for (Eigen::Index i = 0; i < x.size(); ++i) (*y)[i] += damping_[i] * x[i] - Wx_[static_cast<size_t>(i)];
}

void ImplicitSchur::Precondition(const VecX& r, VecX* z) const {
  const BlockStructure& s = system_->structure;
  z->setZero();
  for (size_t j = 0; j < s.poses.size(); ++j) {
    kernels::AddSymmetric<Eigen::Dynamic>(&inverses_[static_cast<size_t>(block_begin_[j])], r.data() + s.pose_offset[j],
                                          s.pose_dim[j], z->data() + s.pose_offset[j]);
  }
}

}  // namespace ch5
