#pragma once
/// What is done with one landmark's blocks once the normal equations stand. P×L are the sizes of H_pl's blocks, or
/// Eigen::Dynamic; Scalar is the type they are stored in.

#include <algorithm>

#include "ch5_backend/sparse/eliminate.h"
#include "ch5_backend/sparse/kernels/invert.h"

namespace ch5::kernels {

template <int P, int L, typename Scalar>
struct LandmarkKernels {
  static constexpr bool kFixed = P != Eigen::Dynamic && L != Eigen::Dynamic;

  // damped = H_ll + λD
  static CH5_INLINE void Damp(const Structure& s, const Linearized& y, int l, int dim, const DampingRule& rule,
                              double* damped) {
    std::copy_n(&y.H_ll[s.landmark_block[l]], dim * dim, damped);
    for (int i = 0; i < dim; ++i) damped[i * dim + i] += rule.lambda * DampingEntry(rule.damping, damped[i * dim + i]);
  }

  // Landmarks [first, first + count), one in each lane; lanes without one hold copies of the last.
  static CH5_INLINE bool InvertPack(const Structure& s, const Linearized& y, int first, int count,
                                    const DampingRule& rule, Eliminated* out) {
    double damped[kPack][L * L];
    const double *A_of[kPack], *b_of[kPack];
    for (int k = 0; k < kPack; ++k) {
      const int l = std::min(k, count - 1);
      if (l == k) Damp(s, y, first + l, L, rule, damped[l]);
      A_of[k] = damped[l];
      b_of[k] = y.b.data() + s.landmark_offset[first + l];
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
      const int block = s.landmark_block[first + k], row = s.landmark_offset[first + k] - s.ordering.dim_poses;
      for (int i = 0; i < L * L; ++i) out->H_ll_inverse[block + i] = V[i][k];
      for (int i = 0; i < L * L; ++i) out->G_inverse[block + i] = A[i][k];
      for (int i = 0; i < L; ++i) out->H_ll_inverse_b[row + i] = product[i][k];
    }
    return true;
  }

  static bool InvertOne(const Structure& s, const Linearized& y, int l, const DampingRule& rule, Eliminated* out) {
    const int dim = s.landmark_dim[l], first = s.landmark_offset[l];
    double *G = &out->G_inverse[s.landmark_block[l]], *inverse = &out->H_ll_inverse[s.landmark_block[l]];
    Damp(s, y, l, dim, rule, G);
    if (!InvertSymmetric<L>(G, dim, inverse)) return false;
    double* product = out->H_ll_inverse_b.data() + first - s.ordering.dim_poses;
    std::fill_n(product, dim, 0.0);
    AddSymmetric<L>(inverse, y.b.data() + first, dim, product);
    return true;
  }

  // w += Σ_p H_plᵀ v_p
  static CH5_INLINE void SumOverPoses(const Structure& s, const CouplingBlocks& H_pl, int l, const double* v,
                                      double* w) {
    const auto for_each_block = [&](const auto& take) {
      for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
        const int pose = s.slot_pose[slot];
        take(H_pl.Numbers<Scalar>() + s.slot_block[slot], v + s.pose_offset[pose], s.pose_dim[pose]);
      }
    };
    if constexpr (kFixed) {
      TransposedSum<P, L> sum;
      for_each_block([&](const Scalar* H, const double* v_p, int) { sum.Add(H, v_p); });
      for (int m = 0; m < L; ++m) w[m] += sum.At(m);
    } else {
      const int dim = s.landmark_dim[l];
      for_each_block(
          [&](const Scalar* H, const double* v_p, int pose_dim) { AddTransposed<P, L>(H, v_p, pose_dim, dim, w); });
    }
  }

  // Δx_l, and the landmark's part of the promised decrease.
  static CH5_INLINE double BackSubstitute(const Structure& s, const Linearized& y, const Eliminated& eliminated, int l,
                                          double* delta_x) {
    const int dim = Pick<L>(s.landmark_dim[l]), first = s.landmark_offset[l];
    Scratch<L == Eigen::Dynamic ? L : 2 * L> scratch;
    double* rest = scratch.Zeros(2 * dim);  // b_l − w
    double* H_delta = rest + dim;
    SumOverPoses(s, y.H_pl, l, delta_x, rest);
    for (int i = 0; i < dim; ++i) rest[i] = y.b[first + i] - rest[i];
    double* delta_l = delta_x + first;
    std::fill_n(delta_l, dim, 0.0);
    AddSymmetric<L>(&eliminated.H_ll_inverse[s.landmark_block[l]], rest, dim, delta_l);
    AddSymmetric<L>(&y.H_ll[s.landmark_block[l]], delta_l, dim, H_delta);
    double decrease = 0.0;
    for (int i = 0; i < dim; ++i) decrease += delta_l[i] * (rest[i] - 0.5 * H_delta[i]);
    return decrease;
  }

  // (H v)_l = H_ll v_l + Σ_p H_plᵀ v_p
  static CH5_INLINE void MultiplyLandmark(const Structure& s, const Linearized& y, int l, const double* v,
                                          double* product) {
    const int dim = Pick<L>(s.landmark_dim[l]);
    double* product_l = product + s.landmark_offset[l];
    AddSymmetric<L>(&y.H_ll[s.landmark_block[l]], v + s.landmark_offset[l], dim, product_l);
    SumOverPoses(s, y.H_pl, l, v, product_l);
  }

  // (H v)_j += Σ_l H_jl v_l
  static CH5_INLINE void MultiplyPose(const Structure& s, const Linearized& y, int j, const double* v,
                                      double* product) {
    const int dim = Pick<P>(s.pose_dim[j]);
    for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
      const int slot = s.pose_slots[k], l = s.slot_landmark[slot];
      const Scalar* H_jl = y.H_pl.Numbers<Scalar>() + s.slot_block[slot];
      for (int m = 0; m < Pick<L>(s.landmark_dim[l]); ++m, H_jl += dim) {
        for (int i = 0; i < dim; ++i) product[s.pose_offset[j] + i] += H_jl[i] * v[s.landmark_offset[l] + m];
      }
    }
  }
};

}  // namespace ch5::kernels
