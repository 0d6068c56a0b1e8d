#include "ch5_backend/sparse/schur_coupling.h"

#include <algorithm>

#include "ch5_backend/sparse/landmark_kernels.h"

namespace ch5 {
namespace {

// P×L are the blocks' sizes, or Dynamic: any.
template <int P, int L>
struct Loop {
  static CH5_INLINE void Body(const SchurCoupling::Task& task) {
    const BlockSystem& y = *task.system;
    const BlockStructure& s = y.structure;
    thread_local std::vector<double> scratch;
    for (int l = task.begin; l < task.end; ++l) {
      const int dim = kernels::Pick<L>(s.landmark_dim[l]);
      scratch.assign(static_cast<size_t>(2 * dim), 0.0);
      double *w = scratch.data(), *v = w + dim;  // −Σ Eᵀx and C⁻¹ times it
      kernels::LandmarkKernels<P, L, double>::SumOverPoses(y, l, task.x, w);
      for (int m = 0; m < dim; ++m) w[m] = -w[m];
      kernels::AddSymmetric<L>(&y.H_mm_inverse[s.landmark_block[l]], w, dim, v);
      for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
        const int p = s.slot_pose[slot];
        kernels::SubtractProductVector<P, L>(&y.H_pm.doubles[s.slot_block[slot]], v, s.pose_dim[p], dim,
                                             task.sums + task.padded_offset[p]);
      }
    }
  }

  static void Portable(const SchurCoupling::Task& task) { Body(task); }
  CH5_WITH_AVX2 static void Avx2(const SchurCoupling::Task& task) { Body(task); }
  static SchurCoupling::Run Choose() { return HasAvx2() ? Avx2 : Portable; }
};

SchurCoupling::Run RunFor(int pose_dim, int landmark_dim) {
  if (pose_dim == 9 && landmark_dim == 3) return Loop<9, 3>::Choose();
  if (pose_dim == 6 && landmark_dim == 3) return Loop<6, 3>::Choose();
  if (pose_dim == 6 && landmark_dim == 1) return Loop<6, 1>::Choose();
  return Loop<Eigen::Dynamic, Eigen::Dynamic>::Choose();
}

}  // namespace

SchurCoupling::SchurCoupling(int pose_dim, int landmark_dim) : run_(RunFor(pose_dim, landmark_dim)) {}

void SchurCoupling::Prepare(const BlockSystem& system) {
  const BlockStructure& s = system.structure;
  CutPieces(s);
  padded_offset_.assign(1, 0);
  for (const int dim : s.pose_dim) padded_offset_.push_back(padded_offset_.back() + Stride(dim));
  sums_.assign((piece_begin_.size() - 1) * static_cast<size_t>(padded_offset_.back()), 0.0);
}

// Pieces of about equal work, cut by the structure alone.
void SchurCoupling::CutPieces(const BlockStructure& s) {
  constexpr int kSlots = 8192, kMost = 64;
  const int slots = static_cast<int>(s.slot_pose.size()), landmarks = static_cast<int>(s.landmarks.size());
  const size_t count = static_cast<size_t>(std::clamp(slots / kSlots, 1, kMost));
  piece_begin_.assign(1, 0);
  for (int l = 0; l < landmarks; ++l) {
    const double goal =
        static_cast<double>(slots) * static_cast<double>(piece_begin_.size()) / static_cast<double>(count);
    if (piece_begin_.size() < count && s.landmark_slots[l] >= goal) piece_begin_.push_back(l);
  }
  piece_begin_.push_back(landmarks);
}

void SchurCoupling::Multiply(const BlockSystem& system, const double* x, double* y, ThreadPool* pool) {
  const BlockStructure& s = system.structure;
  const int pieces = static_cast<int>(piece_begin_.size()) - 1;
  const ptrdiff_t size = padded_offset_.back();
  pool->Run(pieces, [&](int piece) {
    double* sums = sums_.data() + piece * size;
    std::fill_n(sums, size, 0.0);
    run_({&system, padded_offset_.data(), piece_begin_[piece], piece_begin_[piece + 1], x, sums});
  });
  ParallelFor(pool, static_cast<int>(s.poses.size()), 256, [&](int begin, int end) {
    for (int j = begin; j < end; ++j) {
      double* y_j = y + s.pose_offset[j];
      std::fill_n(y_j, s.pose_dim[j], 0.0);
      for (int piece = 0; piece < pieces; ++piece) {
        const double* sum = sums_.data() + piece * size + padded_offset_[j];
        for (int i = 0; i < s.pose_dim[j]; ++i) y_j[i] += sum[i];
      }
    }
  });
}

}  // namespace ch5
