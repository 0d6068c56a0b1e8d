#include "ch5_backend/solve/schur_coupling.h"

#include <algorithm>

#include "ch5_backend/solve/block_kernels.h"

namespace ch5 {
namespace {

// Landmarks in pieces of about equal work, cut by the structure alone.
class Pieces {
 public:
  void Cut(const BlockStructure& s) {
    constexpr int kSlots = 8192, kMost = 64;
    const int slots = static_cast<int>(s.slot_pose.size()), landmarks = static_cast<int>(s.landmarks.size());
    const int count = std::clamp(slots / kSlots, 1, kMost);
    begin_.assign(1, 0);
    for (int l = 0; l < landmarks; ++l) {
      const double goal = static_cast<double>(slots) * static_cast<double>(begin_.size()) / count;
      if (Count() + 1 < count && s.landmark_slots[l] >= goal) begin_.push_back(l);
    }
    begin_.push_back(landmarks);
  }
  int Count() const { return static_cast<int>(begin_.size()) - 1; }
  int Begin(int piece) const { return begin_[piece]; }
  int End(int piece) const { return begin_[piece + 1]; }

 private:
  std::vector<int> begin_{0};
};

// Eight numbers, and four, anywhere in memory.
template <typename Scalar>
struct Simd;
template <>
struct Simd<float> {
  typedef float Eight __attribute__((vector_size(32), aligned(4), may_alias));
  typedef float Four __attribute__((vector_size(16), aligned(4), may_alias));
};
template <>
struct Simd<double> {
  typedef double Eight __attribute__((vector_size(64), aligned(8), may_alias));
  typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));
};

// A block E_pl (P×L) as it is stored:        columns 0 … L−1 of rows 0 … 7, each one Eight (zeros below row P − 1)
//                                            row 8, if there is one, as one Four (zeros right of column L − 1)
// A pose's part of x or y:                   rows 0 … 7, then row 8 as the first (x) or the sum (y) of a Four
template <typename Scalar, int P, int L>
struct Layout {
  static_assert(P <= 9 && L <= 4);
  static constexpr bool kHasTail = P > 8;
  static constexpr int kHead = std::min(P, 8);
  static constexpr int kBlock = 8 * L + (kHasTail ? 4 : 0);
  static constexpr int kPose = 8 + (kHasTail ? 4 : 0);
  using Eight = typename Simd<Scalar>::Eight;
  using Four = typename Simd<Scalar>::Four;
};

template <typename Scalar, int P, int L>
struct Loops {
  using Shape = Layout<Scalar, P, L>;
  using Eight = typename Shape::Eight;
  using Four = typename Shape::Four;

  // w = Σ_p E_plᵀ x_p over the landmark's slots, column by column in eight partial sums.
  static CH5_INLINE void Gather(const BlockStructure& s, int l, const Scalar* blocks, const Scalar* x, double* w) {
    Eight sums[L] = {};
    Four tail = {};
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const Scalar* E = blocks + static_cast<ptrdiff_t>(slot) * Shape::kBlock;
      const Scalar* x_p = x + s.slot_pose[slot] * Shape::kPose;
      const Eight head = *reinterpret_cast<const Eight*>(x_p);
      CH5_UNROLL
      for (int m = 0; m < L; ++m) sums[m] += *reinterpret_cast<const Eight*>(E + 8 * m) * head;
      if constexpr (Shape::kHasTail) tail += *reinterpret_cast<const Four*>(E + 8 * L) * x_p[8];
    }
    for (int m = 0; m < L; ++m) {
      w[m] = static_cast<double>(tail[m % 4]);
      for (int k = 0; k < 8; ++k) w[m] += static_cast<double>(sums[m][k]);
    }
  }

  // y_p += E_pl v
  static CH5_INLINE void Scatter(const BlockStructure& s, int l, const Scalar* blocks, const double* v, Scalar* y) {
    Four row = {};
    for (int m = 0; m < L; ++m) row[m] = static_cast<Scalar>(v[m]);
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const Scalar* E = blocks + static_cast<ptrdiff_t>(slot) * Shape::kBlock;
      Scalar* y_p = y + s.slot_pose[slot] * Shape::kPose;
      Eight sum = *reinterpret_cast<const Eight*>(y_p);
      CH5_UNROLL
      for (int m = 0; m < L; ++m) sum += *reinterpret_cast<const Eight*>(E + 8 * m) * row[m];
      *reinterpret_cast<Eight*>(y_p) = sum;
      if constexpr (Shape::kHasTail) {
        *reinterpret_cast<Four*>(y_p + 8) += *reinterpret_cast<const Four*>(E + 8 * L) * row;
      }
    }
  }

  static CH5_INLINE void Multiply(const BlockSystem& system, int begin, int end, const Scalar* blocks, const Scalar* x,
                                  Scalar* y) {
    const BlockStructure& s = system.structure;
    for (int l = begin; l < end; ++l) {
      double w[L], v[L] = {};
      Gather(s, l, blocks, x, w);
      kernels::AddSymmetric<L>(&system.H_mm_inverse[s.landmark_block[l]], w, L, v);
      Scatter(s, l, blocks, v, y);
    }
  }
  static void MultiplyPortable(const BlockSystem& system, int begin, int end, const Scalar* blocks, const Scalar* x,
                               Scalar* y) {
    Multiply(system, begin, end, blocks, x, y);
  }
  CH5_WITH_AVX2 static void MultiplyAvx2(const BlockSystem& system, int begin, int end, const Scalar* blocks,
                                         const Scalar* x, Scalar* y) {
    Multiply(system, begin, end, blocks, x, y);
  }
};

template <typename Scalar, int P, int L>
class PackedCoupling : public SchurCoupling {
  using Shape = Layout<Scalar, P, L>;

 public:
  void Prepare(const BlockSystem& system) override {
    pieces_.Cut(system.structure);
    blocks_.assign(system.structure.slot_pose.size() * Shape::kBlock, Scalar(0));
    x_.assign(system.structure.poses.size() * Shape::kPose, Scalar(0));
    sums_.assign(static_cast<size_t>(pieces_.Count()) * x_.size(), Scalar(0));
  }

  void Load(const BlockSystem& system, ThreadPool* pool) override {
    const BlockStructure& s = system.structure;
    ParallelFor(pool, static_cast<int>(s.slot_pose.size()), 4096, [&](int begin, int end) {
      for (int slot = begin; slot < end; ++slot) {
        const double* E = &system.H_pm[s.slot_block[slot]];
        Scalar* block = blocks_.data() + static_cast<ptrdiff_t>(slot) * Shape::kBlock;
        for (int m = 0; m < L; ++m, E += P) {
          for (int i = 0; i < Shape::kHead; ++i) block[8 * m + i] = static_cast<Scalar>(E[i]);
          if (Shape::kHasTail) block[8 * L + m] = static_cast<Scalar>(E[8]);
        }
      }
    });
  }

  void Multiply(const BlockSystem& system, const double* x, double* y, ThreadPool* pool) override {
    const int poses = static_cast<int>(system.structure.poses.size());
    for (int j = 0; j < poses; ++j) {
      for (int i = 0; i < P; ++i) x_[j * Shape::kPose + i] = static_cast<Scalar>(x[j * P + i]);
    }
    using Run = void (*)(const BlockSystem&, int, int, const Scalar*, const Scalar*, Scalar*);
    static const Run run = HasAvx2() ? Loops<Scalar, P, L>::MultiplyAvx2 : Loops<Scalar, P, L>::MultiplyPortable;
    pool->Run(pieces_.Count(), [&](int piece) {
      Scalar* sum = sums_.data() + static_cast<size_t>(piece) * x_.size();
      std::fill_n(sum, x_.size(), Scalar(0));
      run(system, pieces_.Begin(piece), pieces_.End(piece), blocks_.data(), x_.data(), sum);
    });
    ParallelFor(pool, poses, 256, [&](int begin, int end) {
      for (int j = begin; j < end; ++j) AddPieces(j, y + j * P);
    });
  }

 private:
  void AddPieces(int j, double* y) const {
    std::fill_n(y, P, 0.0);
    for (int piece = 0; piece < pieces_.Count(); ++piece) {
      const Scalar* sum = sums_.data() + static_cast<size_t>(piece) * x_.size() + j * Shape::kPose;
      for (int i = 0; i < Shape::kHead; ++i) y[i] += static_cast<double>(sum[i]);
      for (int k = 8; k < Shape::kPose; ++k) y[8 % P] += static_cast<double>(sum[k]);
    }
  }

  template <typename T>
  using Aligned = std::vector<T, Eigen::aligned_allocator<T>>;
  Pieces pieces_;
  Aligned<Scalar> blocks_, x_, sums_;
};

// Any sizes: the blocks are read where they are.
class GeneralCoupling : public SchurCoupling {
 public:
  void Prepare(const BlockSystem& system) override {
    const BlockStructure& s = system.structure;
    pieces_.Cut(s);
    offset_.assign(1, 0);
    for (const int dim : s.pose_dim) offset_.push_back(offset_.back() + Stride(dim));
    sums_.assign(static_cast<size_t>(pieces_.Count() * offset_.back()), 0.0);
  }
  void Load(const BlockSystem&, ThreadPool*) override {}

  void Multiply(const BlockSystem& system, const double* x, double* y, ThreadPool* pool) override {
    const BlockStructure& s = system.structure;
    pool->Run(pieces_.Count(), [&](int piece) {
      double* sums = sums_.data() + static_cast<ptrdiff_t>(piece) * offset_.back();
      std::fill_n(sums, offset_.back(), 0.0);
      for (int l = pieces_.Begin(piece); l < pieces_.End(piece); ++l) MultiplyLandmark(system, l, x, sums);
    });
    for (size_t j = 0; j < s.poses.size(); ++j) {
      for (int i = 0; i < s.pose_dim[j]; ++i) {
        double sum = 0.0;
        for (int piece = 0; piece < pieces_.Count(); ++piece) {
          sum += sums_[static_cast<size_t>(piece * offset_.back() + offset_[j] + i)];
        }
        y[s.pose_offset[j] + i] = sum;
      }
    }
  }

 private:
  void MultiplyLandmark(const BlockSystem& system, int l, const double* x, double* sums) const {
    constexpr int kAny = Eigen::Dynamic;
    const BlockStructure& s = system.structure;
    const int dim = s.landmark_dim[l];
    thread_local std::vector<double> scratch;
    scratch.assign(static_cast<size_t>(2 * dim), 0.0);
    double *w = scratch.data(), *v = w + dim;  // −Σ Eᵀx and C⁻¹ times it
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const int p = s.slot_pose[slot];
      kernels::AddTransposed<kAny, kAny>(&system.H_pm[s.slot_block[slot]], x + s.pose_offset[p], s.pose_dim[p], dim,
                                         -1.0, w);
    }
    kernels::AddSymmetric<kAny>(&system.H_mm_inverse[s.landmark_block[l]], w, dim, v);
    for (int slot = s.landmark_slots[l]; slot < s.landmark_slots[l + 1]; ++slot) {
      const int p = s.slot_pose[slot];
      kernels::SubtractProductVector<kAny, kAny>(&system.H_pm[s.slot_block[slot]], v, s.pose_dim[p], dim,
                                                 sums + offset_[p]);
    }
  }

  Pieces pieces_;
  std::vector<int> offset_;
  std::vector<double> sums_;
};

template <int P, int L>
std::unique_ptr<SchurCoupling> MakePacked(bool single_precision) {
  if (single_precision) return std::make_unique<PackedCoupling<float, P, L>>();
  return std::make_unique<PackedCoupling<double, P, L>>();
}

}  // namespace

std::unique_ptr<SchurCoupling> MakeSchurCoupling(int pose_dim, int landmark_dim, bool single_precision) {
  if (pose_dim == 9 && landmark_dim == 3) return MakePacked<9, 3>(single_precision);
  if (pose_dim == 6 && landmark_dim == 3) return MakePacked<6, 3>(single_precision);
  if (pose_dim == 6 && landmark_dim == 1) return MakePacked<6, 1>(single_precision);
  return std::make_unique<GeneralCoupling>();
}

}  // namespace ch5
