#include "ch5_backend/sparse/steps/eliminate.h"

#include <algorithm>
#include <atomic>

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/kernels/landmark.h"

namespace ch5 {
namespace {

constexpr int kLandmarks = 64;  // a task's

// ---- (H_ll + λD)⁻¹ = G⁻ᵀG⁻¹ -------------------------------------------------------------------------------------

// damped = H_ll + λD
CH5_INLINE void Damp(const double* H_ll, int dim, const DampingRule& rule, double* damped) {
  std::copy_n(H_ll, dim * dim, damped);
  for (int i = 0; i < dim; ++i) damped[i * dim + i] += rule.lambda * DampingEntry(rule.damping, damped[i * dim + i]);
}

// Landmarks [first, first + count) of L rows, one in each lane; lanes without one hold copies of the last.
template <int L>
CH5_INLINE bool InvertPack(const Structure& s, const Linearized& y, int first, int count, const DampingRule& rule,
                           Eliminated* out) {
  double damped[kPack][L * L];
  const double *A_of[kPack], *b_of[kPack];
  for (int k = 0; k < kPack; ++k) {
    const int l = std::min(k, count - 1);
    if (l == k) Damp(&y.H_ll[s.landmark_block[first + l]], L, rule, damped[l]);
    A_of[k] = damped[l];
    b_of[k] = y.b.data() + s.landmark_offset[first + l];
  }
  WideLanes A[L * L], V[L * L], b[L], product[L];
  GatherLanes<L * L>(A_of, A);
  GatherLanes<L>(b_of, b);
  if (!kernels::InvertSymmetric<L>(A, L, V)) return false;
  for (int r = 0; r < L; ++r) {
    product[r] = V[r] * b[0];
    for (int c = 1; c < L; ++c) product[r] += V[c * L + r] * b[c];
  }
  const bool has_roots = !out->G_inverse.empty();
  for (int k = 0; k < count; ++k) {
    const int block = s.landmark_block[first + k], row = s.landmark_offset[first + k] - s.ordering.dim_poses;
    for (int i = 0; i < L * L; ++i) out->H_ll_inverse[block + i] = V[i][k];
    for (int i = 0; i < L * L && has_roots; ++i) out->G_inverse[block + i] = A[i][k];
    for (int i = 0; i < L; ++i) out->H_ll_inverse_b[row + i] = product[i][k];
  }
  return true;
}

// One landmark of any size.
CH5_INLINE bool InvertOne(const Structure& s, const Linearized& y, int l, const DampingRule& rule, Eliminated* out) {
  const int dim = s.landmark_dim[l], first = s.landmark_offset[l], block = s.landmark_block[l];
  thread_local Array<double> scratch;
  if (out->G_inverse.empty()) scratch.resize(static_cast<size_t>(dim * dim));
  double *G = out->G_inverse.empty() ? scratch.data() : &out->G_inverse[block], *inverse = &out->H_ll_inverse[block];
  Damp(&y.H_ll[block], dim, rule, G);
  if (!kernels::InvertSymmetric<Eigen::Dynamic>(G, dim, inverse)) return false;
  double* product = out->H_ll_inverse_b.data() + first - s.ordering.dim_poses;
  std::fill_n(product, dim, 0.0);
  kernels::AddSymmetric<Eigen::Dynamic>(inverse, y.b.data() + first, dim, product);
  return true;
}

// The same, but for a block without inverse.
void InvertSingular(const Structure& s, const Linearized& y, int l, const DampingRule& rule, SingularRoot singular_root,
                    Eliminated* out) {
  const int dim = s.landmark_dim[l], first = s.landmark_offset[l], block = s.landmark_block[l];
  MatXX damped(dim, dim);
  Damp(&y.H_ll[block], dim, rule, damped.data());
  const MatXX K = singular_root(damped);
  Eigen::Map<MatXX>(&out->G_inverse[block], dim, dim) = K;
  Eigen::Map<MatXX>(&out->H_ll_inverse[block], dim, dim) = K.transpose() * K;
  out->H_ll_inverse_b.segment(first - s.ordering.dim_poses, dim) = K.transpose() * (K * y.b.segment(first, dim));
}

template <int P, int L>
struct InvertRange {
  using Signature = bool(const Structure&, const Linearized&, int begin, int end, const DampingRule&, Eliminated*);
  template <SimdLevel>
  static CH5_INLINE bool Run(const Structure& s, const Linearized& y, int begin, int end, const DampingRule& rule,
                             Eliminated* out) {
    bool good = true;
    if constexpr (L != Eigen::Dynamic) {
      for (int l = begin; l < end; l += kPack) good &= InvertPack<L>(s, y, l, std::min(kPack, end - l), rule, out);
    } else {
      for (int l = begin; l < end && good; ++l) good = InvertOne(s, y, l, rule, out);
    }
    return good;
  }
};

// ---- groups -----------------------------------------------------------------------------------------------------

// Sorted like this, landmarks that the same poses see are next to each other.
void FindGroups(const Structure& s, SchurGroups* found) {
  const auto slots = [&](int l) { return s.slot_pose.begin() + s.landmark_slots[l]; };
  int num_blocks = 0;
  found->poses.reserve(s.slot_pose.size());
  found->groups.reserve(s.landmarks.size());
  for (int l = 0; l < s.NumLandmarks(); ++l) {
    const bool same = l > 0 && s.landmark_dim[l] == s.landmark_dim[l - 1] &&
                      std::equal(slots(l), slots(l + 1), slots(l - 1), slots(l));
    if (same) {
      found->groups.back().last = l + 1;
      continue;
    }
    const int first_pose = static_cast<int>(found->poses.size());
    SchurGroup group{l, l + 1, first_pose, first_pose, 0, num_blocks};
    for (auto pose = slots(l); pose != slots(l + 1); ++pose) {
      found->poses.push_back({*pose, s.pose_dim[*pose], group.rows, s.pose_offset[*pose]});
      group.rows += s.pose_dim[*pose];
    }
    group.poses_end = static_cast<int>(found->poses.size());
    const int num_poses = group.poses_end - group.poses_begin;
    num_blocks += num_poses * (num_poses + 1) / 2;
    found->groups.push_back(group);
  }
  found->blocks.resize(static_cast<size_t>(num_blocks));
}

// The groups' blocks of S, column by column of S: no block has to be searched for.
void FindBlocks(const Structure& s, const SymmetricBlockMatrix& S, SchurGroups* found) {
  Array<int> blocks_begin(s.landmarks.size(), -1), block_of_row(s.poses.size());
  for (const SchurGroup& group : found->groups) blocks_begin[group.first] = group.blocks_begin;
  for (int j = 0; j < s.NumPoses(); ++j) {
    for (int block = S.ColumnBegin(j); block < S.ColumnBegin(j + 1); ++block) block_of_row[S.Row(block)] = block;
    for (const int slot : s.pose_slots[j]) {
      const int l = s.slot_landmark[slot];
      if (blocks_begin[l] < 0) continue;
      const int first = s.landmark_slots[l], end = s.landmark_slots[l + 1], column = slot - first;
      int* block = &found->blocks[blocks_begin[l] + column * (end - first) - column * (column - 1) / 2];
      for (int below = slot; below < end; ++below) *block++ = block_of_row[s.slot_pose[below]];
    }
  }
}

// The multiplications that each column of S costs, about.
Array<double> WorkOfColumns(const Structure& s, const SchurGroups& found) {
  Array<double> work(s.poses.size(), 1.0);
  for (const SchurGroup& group : found.groups) {
    const double columns = 20.0 + s.landmark_dim[group.first] * (group.last - group.first);
    for (int k = group.poses_begin; k < group.poses_end; ++k) {
      const kernels::GroupPose& pose = found.poses[k];
      work[pose.pose] += columns * pose.dim * (group.rows - pose.row);
    }
  }
  return work;
}

// What the kernels need of a group.
kernels::GroupSystem SystemOf(const Structure& s, const Linearized& y, const Eliminated& eliminated,
                              const SchurGroups& groups, const SchurGroup& group) {
  const int l = group.first;
  return {group.last - l,
          s.landmark_dim[l],
          y.Slots(s, l),
          eliminated.G_inverse.data() + s.landmark_block[l],
          y.b.data(),
          s.landmark_offset.data() + l,
          groups.poses.data() + group.poses_begin,
          groups.poses.data() + group.poses_end,
          group.rows,
          groups.blocks.data() + group.blocks_begin};
}

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

}  // namespace

void Eliminated::Resize(const Structure& s, bool is_implicit) {
  SetZeros(static_cast<size_t>(s.num_H_ll_values), &H_ll_inverse);
  SetZeros(is_implicit ? 0 : static_cast<size_t>(s.num_H_ll_values), &G_inverse);
  H_ll_inverse_b.setZero(s.ordering.dim_landmarks);
  b_S.setZero(s.ordering.dim_poses);
  damped_diagonal.setZero(s.ordering.dim_poses);
}

bool InvertLandmarks(const Structure& s, const Linearized& y, const DampingRule& rule, ThreadPool* pool,
                     Eliminated* eliminated, SingularRoot singular_root) {
  const auto invert = Dispatch<InvertRange>(s.sizes.OfLandmarks());
  std::atomic<bool> ok{true};
  ParallelFor(pool, s.NumLandmarks(), kLandmarks, [&](int begin, int end) {
    if (invert(s, y, begin, end, rule, eliminated)) return;
    if (!singular_root) ok = false;
    for (int l = begin; l < end && singular_root; ++l) {
      if (!InvertOne(s, y, l, rule, eliminated)) InvertSingular(s, y, l, rule, singular_root, eliminated);
    }
  });
  return ok;
}

Lists SchurPattern(const Structure& s) {
  Lists pattern(s.poses.size(), s.H_pp_pattern.items.size() + s.slot_pose.size());
  Array<int>& rows = pattern.items;
  Array<int> last_column_of(s.poses.size(), -1);
  const auto add = [&](int i, int j) {
    if (last_column_of[i] != j) rows.push_back(i);
    last_column_of[i] = j;
  };
  for (int j = 0; j < s.NumPoses(); ++j) {
    for (const int i : s.H_pp_pattern[j]) add(i, j);
    for (const int slot : s.pose_slots[j]) {
      for (int other = slot + 1; other < s.landmark_slots[s.slot_landmark[slot] + 1]; ++other)
        add(s.slot_pose[other], j);
    }
    std::sort(rows.begin() + pattern.begin.back(), rows.end());
    pattern.End();
  }
  return pattern;
}

SchurGroups PrepareSchurGroups(const Structure& s, const SymmetricBlockMatrix& S, int threads) {
  SchurGroups found;
  FindGroups(s, &found);
  FindBlocks(s, S, &found);
  int rows = 0, poses = 0;
  for (const SchurGroup& group : found.groups) {
    rows = std::max(rows, group.rows);
    poses = std::max(poses, group.poses_end - group.poses_begin);
  }
  const size_t numbers = kernels::GroupMemory(s.sizes, poses, rows);
  const Array<double> work = WorkOfColumns(s, found);
  double total = 0.0, done = 0.0;
  for (const double amount : work) total += amount;
  for (int j = 0, begin = 0; j < s.NumPoses(); ++j) {
    done += work[j];
    const bool full = done >= total / threads * static_cast<double>(found.ranges.size() + 1);
    if (!full && j + 1 < s.NumPoses()) continue;
    SchurGroups::ColumnRange& range = found.ranges.emplace_back();
    range.begin = begin;
    range.end = j + 1;
    SetZeros(numbers, &range.memory);
    begin = j + 1;
  }
  return found;
}

kernels::PoseRange SchurGroups::PosesIn(const SchurGroup& group, const ColumnRange& range) const {
  const kernels::GroupPose *begin = poses.data() + group.poses_begin, *end = poses.data() + group.poses_end;
  const auto first_from = [&](int pose) {
    return std::lower_bound(begin, end, pose, [](const kernels::GroupPose& a, int p) { return a.pose < p; });
  };
  return {first_from(range.begin), first_from(range.end)};
}

void FormSchurComplement(const Structure& s, const Linearized& y, const DampingRule& rule, SchurGroups* groups,
                         ThreadPool* pool, Eliminated* eliminated) {
  const auto subtract_group = kernels::SubtractGroupFor(s.sizes);
  SymmetricBlockMatrix& S = eliminated->S;
  pool->Run(static_cast<int>(groups->ranges.size()), [&](int k) {
    SchurGroups::ColumnRange& range = groups->ranges[k];
    for (int j = range.begin; j < range.end; ++j) BeginColumn(s, y, j, rule, eliminated);
    for (const SchurGroup& group : groups->groups) {
      const kernels::PoseRange poses = groups->PosesIn(group, range);
      if (poses.begin == poses.end) continue;
      subtract_group(SystemOf(s, y, *eliminated, *groups, group), poses, range.memory.data(), &S,
                     eliminated->b_S.data());
    }
    for (int j = range.begin; j < range.end; ++j) MirrorLower(S.Dim(j), S.Values(S.ColumnBegin(j)));
  });
}

}  // namespace ch5
