#include "ch5_backend/sparse/eliminate.h"

#include <algorithm>
#include <atomic>

#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/sparse/kernels/landmark.h"
#include "ch5_backend/sparse/kernels/schur_group.h"

namespace ch5 {
namespace {

constexpr int kLandmarks = 64;  // a task's

// ---- (H_ll + λD)⁻¹ = G⁻ᵀG⁻¹ -------------------------------------------------------------------------------------

template <int P, int L, typename Scalar>
struct InvertRange {
  using Signature = bool(const Structure&, const Linearized&, int begin, int end, const DampingRule&, Eliminated*);
  template <SimdLevel>
  static CH5_INLINE bool Run(const Structure& s, const Linearized& y, int begin, int end, const DampingRule& rule,
                             Eliminated* out) {
    using Kernels = kernels::LandmarkKernels<P, L, Scalar>;
    bool good = true;
    if constexpr (Kernels::kFixed) {
      for (int l = begin; l < end; l += kPack)
        good &= Kernels::InvertPack(s, y, l, std::min(kPack, end - l), rule, out);
    } else {
      for (int l = begin; l < end && good; ++l) good = Kernels::InvertOne(s, y, l, rule, out);
    }
    return good;
  }
};

// ---- S and b_S --------------------------------------------------------------------------------------------------

// Column j of H_pp + λD, and b_j.
void BeginColumn(const Structure& s, const Linearized& y, int j, const DampingRule& rule, Eliminated* out) {
  SymmetricBlockMatrix& S = out->S;
  const int dim = s.pose_dim[j], offset = s.pose_offset[j];
  int block = y.H_pp.ColumnBegin(j);
  for (int k = S.ColumnBegin(j); k < S.ColumnBegin(j + 1); ++k) {  // H_pp's blocks are among S's
    const int i = S.Row(k), size = Stride(s.pose_dim[i]) * dim;
    const bool in_H = block < y.H_pp.ColumnBegin(j + 1) && y.H_pp.Row(block) == i;
    in_H ? void(std::copy_n(y.H_pp.Values(block++), size, S.Values(k))) : void(std::fill_n(S.Values(k), size, 0.0));
  }
  double* diagonal = S.Values(S.ColumnBegin(j));
  for (int c = 0; c < dim; ++c) {
    double& entry = diagonal[c * Stride(dim) + c];
    entry += rule.lambda * DampingEntry(rule.damping, entry);
    out->damped_diagonal[offset + c] = entry;
  }
  out->b_S.segment(offset, dim) = y.b.segment(offset, dim);
}

// What was added to the diagonal block's lower half holds for the upper one.
void Mirror(int dim, double* block) {
  for (int c = 0; c < dim; ++c) {
    for (int r = c + 1; r < dim; ++r) block[r * Stride(dim) + c] = block[c * Stride(dim) + r];
  }
}

// The general variant: the group's A_i below each other, and G⁻¹b as the last row,
//
//      ┌ H_1l G_l⁻ᵀ │ H_1m G_m⁻ᵀ │ … ┐    a row of blocks for each pose, a column for each landmark of the group;
//  A = │ H_2l G_l⁻ᵀ │ H_2m G_m⁻ᵀ │ … │    C = −A Aᵀ, of which the lower half is needed, holds the group's part of S,
//      └ (G_l⁻¹b_l)ᵀ│ (G_m⁻¹b_m)ᵀ│ … ┘    and in its last row that of b_S
//
// of which a thread needs the rows from its first pose on and the columns up to its last.
class GeneralGroup {
 public:
  static constexpr int kRoom = 2 * kLanes;  // behind the columns of A and C, for whole vectors
  static constexpr int kColumns = 60;       // of A at a time: they stay in the first-level cache

  GeneralGroup(const Structure& s, const SchurGroups& groups, const SchurGroup& group, const GroupPose* begin,
               const GroupPose* end, SchurGroups::ColumnRange* range)
      : s_(s),
        groups_(groups),
        group_(group),
        poses_(groups.poses.data() + group.poses_begin),
        poses_end_(groups.poses.data() + group.poses_end),
        begin_(begin),
        end_(end),
        top_(begin->row),
        rows_(group.rows - top_),
        lda_(Padded(rows_ + 1) + kRoom),
        A_(range->A.data()),
        C_(range->C.data()) {}

  static GroupMemory Memory(int /*poses*/, int rows) {
    const auto lda = static_cast<size_t>(Padded(rows + 1) + kRoom);
    return {lda * (kColumns + 8) + kernels::kOverread, lda * lda + kernels::kOverread};
  }

  void Subtract(const Linearized& y, Eliminated* out) {
    const int columns = end_ == poses_end_ ? rows_ + 1 : end_->row - top_, dim = s_.landmark_dim[group_.first];
    const int batch = std::max(1, kColumns / dim);
    for (int l = group_.first; l < group_.last; l += batch) {
      const int count = std::min(batch, group_.last - l);
      for (int k = 0; k < count; ++k) FillColumns(y, *out, l + k, dim, A_ + k * dim * lda_);
      MultiplyOut(columns, count * dim, l == group_.first ? kernels::Old::kForget : kernels::Old::kKeep);
    }
    AddBlocks(out);
  }

 private:
  // The columns of A that belong to landmark l:  H_pl G⁻ᵀ, and G⁻¹b. Whole registers are written; what is too much lies
  // where the next pose will write.
  void FillColumns(const Linearized& y, const Eliminated& eliminated, int l, int dim, double* A_l) const {
    const double *G_inverse = &eliminated.G_inverse[s_.landmark_block[l]], *b = y.b.data() + s_.landmark_offset[l];
    const int* block = &s_.slot_block[s_.landmark_slots[l]];
    for (const GroupPose* pose = begin_; pose != poses_end_; ++pose) {
      const double* H_pl = &y.H_pl.doubles[block[pose - poses_]];
      double* A = A_l + pose->row - top_;
      for (int c = 0; c < dim; ++c) {
        for (int k = 0; k < Stride(pose->dim) / kLanes; ++k) {
          Lanes sum = AsLanes(H_pl)[k] * G_inverse[c];
          for (int m = 1; m <= c; ++m) sum += AsLanes(H_pl + m * pose->dim)[k] * G_inverse[m * dim + c];
          AsLanes(A + c * lda_)[k] = sum;
        }
      }
    }
    for (int c = 0; c < dim; ++c) {
      double sum = 0.0;
      for (int m = 0; m <= c; ++m) sum += G_inverse[m * dim + c] * b[m];
      A_l[rows_ + c * lda_] = sum;
    }
  }

  // C −= A Aᵀ over k columns of A.
  void MultiplyOut(int columns, int k, kernels::Old old) const {
    kernels::SubtractProductAAt(columns, k, A_, lda_, C_, lda_, old, columns == rows_ + 1 ? kRoom : 0);
    if (columns < rows_) {
      kernels::SubtractProductABt(rows_ + 1 - columns, columns, k, A_ + columns, lda_, A_, lda_, C_ + columns, lda_,
                                  old);
    }
  }

  // S and b_S take their blocks of C.
  void AddBlocks(Eliminated* out) const {
    const auto n = static_cast<int>(poses_end_ - poses_);
    for (const GroupPose* j = begin_; j != end_; ++j) {
      const auto k = static_cast<int>(j - poses_);
      const int* block = groups_.blocks.data() + group_.blocks_begin + k * n - k * (k - 1) / 2;
      const double* column = C_ + static_cast<ptrdiff_t>(j->row - top_) * lda_;
      for (const GroupPose* i = j; i != poses_end_; ++i) {
        const double* C_ij = column + i->row - top_;
        double* S_ij = out->S.Values(*block++);
        for (int c = 0; c < j->dim; ++c, C_ij += lda_, S_ij += Stride(i->dim)) {
          for (int r = 0; r < i->dim; ++r) S_ij[r] += C_ij[r];
        }
      }
      double* b_j = out->b_S.data() + s_.pose_offset[j->pose];
      for (int c = 0; c < j->dim; ++c) b_j[c] += column[c * lda_ + rows_];
    }
  }

  const Structure& s_;
  const SchurGroups& groups_;
  const SchurGroup& group_;
  const GroupPose *poses_, *poses_end_;  // the group's
  const GroupPose *begin_, *end_;        // those whose columns are the thread's
  int top_, rows_, lda_;                 // A's first row in the group, its rows without b's, its leading dimension
  double *A_, *C_;
};

}  // namespace

void Eliminated::Resize(const Structure& s) {
  H_ll_inverse.assign(static_cast<size_t>(s.num_H_ll_values), 0.0);
  G_inverse.assign(static_cast<size_t>(s.num_H_ll_values), 0.0);
  H_ll_inverse_b.setZero(s.ordering.dim_landmarks);
  b_S.setZero(s.ordering.dim_poses);
  damped_diagonal.setZero(s.ordering.dim_poses);
}

bool InvertLandmarks(const Structure& s, const Linearized& y, const DampingRule& rule, ThreadPool* pool,
                     Eliminated* eliminated) {
  const auto invert = Dispatch<InvertRange>(y.SizesFor(s));
  std::atomic<bool> ok{true};
  ParallelFor(pool, s.NumLandmarks(), kLandmarks, [&](int begin, int end) {
    if (!invert(s, y, begin, end, rule, eliminated)) ok = false;
  });
  return ok;
}

SchurGroups PrepareSchurGroups(const Structure& s, const SymmetricBlockMatrix& S, int threads) {
  return FindSchurGroups(s, S, threads, s.sizes.AreFixed() ? kernels::FixedSizeMemory : GeneralGroup::Memory);
}

void FormSchurComplement(const Structure& s, const Linearized& y, const DampingRule& rule, SchurGroups* groups,
                         ThreadPool* pool, Eliminated* eliminated) {
  const bool fixed = s.sizes.AreFixed();
  const auto subtract_group = kernels::SubtractGroupFor(y.SizesFor(s));
  SymmetricBlockMatrix& S = eliminated->S;
  pool->Run(static_cast<int>(groups->ranges.size()), [&](int k) {
    SchurGroups::ColumnRange& range = groups->ranges[k];
    for (int j = range.begin; j < range.end; ++j) BeginColumn(s, y, j, rule, eliminated);
    for (const SchurGroup& group : groups->groups) {
      const auto [begin, end] = groups->PosesIn(group, range);
      if (begin == end) continue;
      if (fixed) {
        subtract_group(s, y, *groups, group, {begin, end}, range.A.data(), eliminated);
      } else {
        GeneralGroup(s, *groups, group, begin, end, &range).Subtract(y, eliminated);
      }
    }
    for (int j = range.begin; j < range.end; ++j) Mirror(S.Dim(j), S.Values(S.ColumnBegin(j)));
  });
}

}  // namespace ch5
