#pragma once
/// What is done with one landmark's blocks once the normal equations are assembled: H_ll is inverted, alone or eight at once, and
/// what the poses that see it add is summed. P×L are the sizes of H_pl's blocks, or Eigen::Dynamic.

#include <algorithm>
#include <cmath>
#include <limits>

#include "ch5_backend/linear/block_matrix.h"
#include "ch5_backend/linear/pivot_rule.h"
#include "ch5_backend/math/dispatch.h"
#include "ch5_backend/sparse/kernels/slot_factors.h"

namespace ch5::kernels {

constexpr int ScratchSize(int rows, int columns) {
  return rows == Eigen::Dynamic || columns == Eigen::Dynamic ? Eigen::Dynamic : Stride(rows) * columns;
}

/// Zeroed memory for one landmark, aligned: on the stack where the size is known, else memory that each thread keeps,
/// apart for each `Index`.
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
    SetZeros(static_cast<size_t>(size), &values);
    return values.data();
  }
};

CH5_INLINE bool AllTrue(bool good) { return good; }
template <typename Mask>
CH5_INLINE bool AllTrue(const Mask& good) {
  bool all = true;
  for (int k = 0; k < kPack; ++k) all = all && good[k];
  return all;
}
CH5_INLINE void SquareRoot(const double& x, double* root) { *root = std::sqrt(x); }
CH5_INLINE void SquareRoot(const WideLanes& x, WideLanes* root) {
  for (int k = 0; k < kPack; ++k) (*root)[k] = std::sqrt(x[k]);
}

/// V = A⁻¹ by Cholesky, both l×l without padding; A is overwritten by its factor. T is a number, or one for each lane.
/// @return  false unless every pivot exceeds its rounding (linear/pivot_rule.h)
template <int L, typename T>
CH5_INLINE bool InvertSymmetric(T* A, int l_size, T* V) {
  const int l = Pick<L>(l_size);
  const double rounding = PivotRounding(l), most = std::numeric_limits<double>::max();
  auto good = A[0] == A[0];
  for (int j = 0; j < l; ++j) {  // A = G Gᵀ, G in the lower half
    T pivot = A[j * l + j], root;
    for (int k = 0; k < j; ++k) pivot -= A[k * l + j] * A[k * l + j];
    good = good & (pivot > rounding * A[j * l + j]) & (pivot <= most);
    SquareRoot(pivot, &root);
    root = 1.0 / root;
    for (int i = j + 1; i < l; ++i) {
      T sum = A[j * l + i];
      for (int k = 0; k < j; ++k) sum -= A[k * l + i] * A[k * l + j];
      A[j * l + i] = sum * root;
    }
    A[j * l + j] = root;  // the reciprocal of G_jj
  }
  for (int c = 0; c < l; ++c) {  // G⁻¹ in place, column by column
    for (int i = c + 1; i < l; ++i) {
      T sum = {};
      for (int k = c; k < i; ++k) sum -= A[k * l + i] * A[c * l + k];
      A[c * l + i] = sum * A[i * l + i];
    }
  }
  for (int c = 0; c < l; ++c) {  // V = G⁻ᵀG⁻¹
    for (int r = c; r < l; ++r) {
      T sum = A[r * l + r] * A[c * l + r];
      for (int k = r + 1; k < l; ++k) sum += A[r * l + k] * A[c * l + k];
      V[c * l + r] = V[r * l + c] = sum;
    }
  }
  return AllTrue(good);
}

/// y (l) += V x;  V is l×l without padding, symmetric.
template <int L>
CH5_INLINE void AddSymmetric(const double* V, const double* x, int l_size, double* y) {
  const int l = Pick<L>(l_size);
  for (int c = 0; c < l; ++c) {
    for (int k = 0; k < l; ++k) y[k] += V[c * l + k] * x[c];
  }
}

/// Σ Wᵀx over blocks H (p×L) of one landmark, summed across lanes only once.
template <int P, int L>
class TransposedSum {
 public:
  CH5_INLINE void Add(const double* H, const double* x, int p_size) {
    const int p = Pick<P>(p_size), whole = p / kLanes;
    PrefetchPageAhead<kMost<P> * L>(H);
    CH5_UNROLL
    for (int m = 0; m < L; ++m, H += p) {
      CH5_UNROLL
      for (int k = 0; k < kMost<P> / kLanes; ++k) {
        if (k < whole) sums_[m] += AsLanes(H)[k] * AsLanes(x)[k];
      }
      CH5_UNROLL
      for (int k = whole * kLanes; k < p; ++k) rest_[m] += H[k] * x[k];
    }
  }
  CH5_INLINE double At(int m) const { return rest_[m] + ((sums_[m][0] + sums_[m][1]) + (sums_[m][2] + sums_[m][3])); }

 private:
  Lanes sums_[L] = {};
  double rest_[L] = {};
};

/// y (l) += Wᵀx;  H is p×l.
template <int P, int L>
CH5_INLINE void AddTransposed(const double* H, const double* x, int p_size, int l_size, double* y) {
  const int p = Pick<P>(p_size), l = Pick<L>(l_size), whole = p / kLanes;
  for (int m = 0; m < l; ++m) {
    const double* column = H + m * p;
    Lanes sums = {};
    for (int k = 0; k < whole; ++k) sums += AsLanes(column)[k] * AsLanes(x)[k];
    double sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    for (int k = whole * kLanes; k < p; ++k) sum += column[k] * x[k];
    y[m] += sum;
  }
}

/// The slots of one landmark: of each a block of H_pl, without padding, and the rows of its pose.
struct LandmarkSlots {
  int begin, end;
  const int *pose, *block;            ///< of each slot: its pose, and where its block begins in H_pl, or null if
  int block_size;                     ///< all have this many numbers
  const int *pose_offset, *pose_dim;  ///< of each pose: its first row, and how many
  const double* H_pl;
  const float* factors;  ///< in its place, slot by slot, or null

  const double* Block(int slot) const { return H_pl + (block ? block[slot] : slot * block_size); }
};

/// The numbers in a block, and what is read behind it; 1 for any sizes.
constexpr int BlockSize(int rows, int columns) {
  return rows == Eigen::Dynamic || columns == Eigen::Dynamic ? 1 : (rows < 0 ? -rows : rows) * columns + kLanes;
}

/// A slot's block of H_pl, which `expanded` (BlockSize numbers) takes if it is stored by its factors.
template <int P, int L>
CH5_INLINE const double* Block(const LandmarkSlots& slots, int slot, double* expanded) {
  if constexpr (P > 0 && L > 0) {
    using Factors = SlotFactors<P, L>;
    if (slots.factors) {
      Factors::Expand(slots.factors + static_cast<ptrdiff_t>(slot) * Factors::kSize, expanded);
      return expanded;
    }
  }
  return slots.Block(slot);
}

/// w (l) += Σ_p H_plᵀ v_p over the poses that see a landmark.
template <int P, int L>
CH5_INLINE void SumOverPoses(const LandmarkSlots& slots, int l_size, const double* v, double* w) {
  constexpr bool kFixed = P != Eigen::Dynamic && L != Eigen::Dynamic;
  if constexpr (P > 0 && L > 0) {
    using Factors = SlotFactors<P, L>;
    if (slots.factors) {
      for (int slot = slots.begin; slot < slots.end; ++slot) {
        Factors::AddTransposed(slots.factors + static_cast<ptrdiff_t>(slot) * Factors::kSize,
                               v + slots.pose_offset[slots.pose[slot]], w);
      }
      return;
    }
  }
  TransposedSum<kFixed ? P : 1, kFixed ? L : 1> sum;  // NOLINT(bugprone-branch-clone): P may be 1
  for (int slot = slots.begin; slot < slots.end; ++slot) {
    const int pose = slots.pose[slot];
    const double *H = slots.Block(slot), *v_p = v + slots.pose_offset[pose];
    if constexpr (kFixed) {
      sum.Add(H, v_p, slots.pose_dim[pose]);
    } else {
      AddTransposed<P, L>(H, v_p, slots.pose_dim[pose], l_size, w);
    }
  }
  for (int m = 0; kFixed && m < L; ++m) w[m] += sum.At(m);
}

}  // namespace ch5::kernels
