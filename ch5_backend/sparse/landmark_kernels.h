#pragma once
/// What is done with each landmark once the normal equations stand: its block is inverted, its step found, its rows of H
/// multiplied. P and L are the poses' and landmarks' dimensions, or Eigen::Dynamic; Scalar is that of H_pm.

#include <algorithm>

#include "ch5_backend/sparse/block_kernels.h"
#include "ch5_backend/sparse/block_passes.h"

namespace ch5::kernels {

/// Zeros for the length of a pass, aligned: on the stack where the size is known, else memory that each thread keeps,
/// one piece for each `Index`.
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

template <int P, int L, typename Scalar>
struct LandmarkKernels {
  static constexpr bool kFixed = P != Eigen::Dynamic && L != Eigen::Dynamic;

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
    if (!InvertSymmetric<L>(A, L, V)) return false;
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
    if (!InvertSymmetric<L>(root, dim, inverse)) return false;
    double* product = y.H_mm_inverse_b.data() + first - s.ordering.dim_poses;
    std::fill_n(product, dim, 0.0);
    AddSymmetric<L>(inverse, y.b.data() + first, dim, product);
    return true;
  }

  // w += Σ_p H_plᵀ v_p
  static CH5_INLINE void SumOverPoses(const BlockSystem& y, int l, const double* v, double* w) {
    const BlockStructure& s = y.structure;
    const auto for_each_block = [&](const auto& take) {
      for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
        const int pose = s.slot_pose[slot];
        take(BlocksOf<Scalar>(y.H_pm) + s.slot_block[slot], v + s.pose_offset[pose], s.pose_dim[pose]);
      }
    };
    if constexpr (kFixed) {
      TransposedSum<P, L> sum;
      for_each_block([&](const Scalar* W, const double* v_p, int) { sum.Add(W, v_p); });
      for (int m = 0; m < L; ++m) w[m] += sum.At(m);
    } else {
      const int dim = s.landmark_dim[l];
      for_each_block(
          [&](const Scalar* W, const double* v_p, int pose_dim) { AddTransposed<P, L>(W, v_p, pose_dim, dim, w); });
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
    AddSymmetric<L>(&y.H_mm_inverse[s.landmark_block[l]], rest, dim, delta_l);
    AddSymmetric<L>(&y.H_mm[s.landmark_block[l]], delta_l, dim, H_delta);
    double decrease = 0.0;
    for (int i = 0; i < dim; ++i) decrease += delta_l[i] * (rest[i] - 0.5 * H_delta[i]);
    return decrease;
  }

  static CH5_INLINE void MultiplyPose(const BlockSystem& y, int j, const double* v, double* product) {
    const BlockStructure& s = y.structure;
    const int dim = Pick<P>(s.pose_dim[j]);
    for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
      const int slot = s.pose_slots[k], l = s.slot_landmark[slot];
      const Scalar* W = BlocksOf<Scalar>(y.H_pm) + s.slot_block[slot];
      for (int m = 0; m < Pick<L>(s.landmark_dim[l]); ++m, W += dim) {
        for (int i = 0; i < dim; ++i) product[s.pose_offset[j] + i] += W[i] * v[s.landmark_offset[l] + m];
      }
    }
  }

  static CH5_INLINE void MultiplyLandmark(const BlockSystem& y, int l, const double* v, double* product) {
    const BlockStructure& s = y.structure;
    const int dim = Pick<L>(s.landmark_dim[l]);
    double* product_l = product + s.landmark_offset[l];
    AddSymmetric<L>(&y.H_mm[s.landmark_block[l]], v + s.landmark_offset[l], dim, product_l);
    SumOverPoses(y, l, v, product_l);
  }
};

}  // namespace ch5::kernels
