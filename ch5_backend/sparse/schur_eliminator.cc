#include "ch5_backend/sparse/schur_eliminator.h"

#include <algorithm>

#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/sparse/block_kernels.h"

namespace ch5 {
namespace {

constexpr int kRoom = 2 * kLanes;  // behind the columns of A and C, for whole vectors
constexpr int kColumns = 60;       // of A at a time: they stay in the first-level cache

// A's part for one pose and one landmark:  A (p×l) = H_pl G⁻ᵀ. Whole registers are written; what is too much lies where
// the next pose will write.
void Scale(const double* H_pl, const double* root, int p, int l, double* A, int lda) {
  const int lanes = Stride(p) / kLanes;
  for (int c = 0; c < l; ++c) {
    for (int k = 0; k < lanes; ++k) {
      Lanes sum = AsLanes(H_pl)[k] * root[c];
      for (int m = 1; m <= c; ++m) sum += AsLanes(H_pl + m * p)[k] * root[m * l + c];
      AsLanes(A + c * lda)[k] = sum;
    }
  }
}

// S (rows×columns, padded) += C
void AddBlock(const double* C, int ldc, int rows, int columns, double* S) {
  for (int c = 0; c < columns; ++c, C += ldc, S += Stride(rows)) {
    for (int r = 0; r < rows; ++r) S[r] += C[r];
  }
}

// The last row of A:  G⁻¹b.
void ScaleRightHandSide(const double* root, const double* b, int l, double* row, int lda) {
  for (int c = 0; c < l; ++c) {
    double sum = 0.0;
    for (int m = 0; m <= c; ++m) sum += root[m * l + c] * b[m];
    row[c * lda] = sum;
  }
}

// Column j of H_pp + λD, and b_j.
void BeginColumn(BlockSystem* system, int j, const DampingRule& rule) {
  BlockSystem& y = *system;
  const BlockStructure& s = y.structure;
  const int dim = s.pose_dim[j], offset = s.pose_offset[j];
  int block = y.H_pp.ColumnBegin(j);
  for (int k = y.S.ColumnBegin(j); k < y.S.ColumnBegin(j + 1); ++k) {  // H_pp's blocks are among S's
    const int i = y.S.Row(k), size = Stride(s.pose_dim[i]) * dim;
    const bool in_H = block < y.H_pp.ColumnBegin(j + 1) && y.H_pp.Row(block) == i;
    in_H ? void(std::copy_n(y.H_pp.Values(block++), size, y.S.Values(k))) : void(std::fill_n(y.S.Values(k), size, 0.0));
  }
  double* diagonal = y.S.Values(y.S.ColumnBegin(j));
  for (int c = 0; c < dim; ++c) {
    double& entry = diagonal[c * Stride(dim) + c];
    entry += rule.lambda * DampingEntry(rule.damping, entry);
    y.scale[offset + c] = entry;
  }
  y.b_schur.segment(offset, dim) = y.b.segment(offset, dim);
}

// What was added to the diagonal block's lower half holds for the upper one.
void Mirror(int dim, double* block) {
  for (int c = 0; c < dim; ++c) {
    for (int r = c + 1; r < dim; ++r) block[r * Stride(dim) + c] = block[c * Stride(dim) + r];
  }
}

}  // namespace

void SchurEliminator::Prepare(const BlockStructure& structure, const SymmetricBlockMatrix& S, int threads,
                              TakeSchurGroup take_group) {
  take_group_ = take_group;
  FindGroups(structure, S);
  CutShares(structure, threads);
}

void SchurEliminator::FindGroups(const BlockStructure& s, const SymmetricBlockMatrix& S) {
  groups_.clear();
  seats_.clear();
  blocks_.clear();
  const auto slots = [&](int l) { return s.slot_pose.begin() + s.landmark_slots[l]; };
  for (int l = 0; l < static_cast<int>(s.landmarks.size()); ++l) {
    const bool same = l > 0 && s.landmark_dim[l] == s.landmark_dim[l - 1] &&
                      std::equal(slots(l), slots(l + 1), slots(l - 1), slots(l));
    if (same) {
      groups_.back().last = l + 1;
      continue;
    }
    Group group{l, l + 1, static_cast<int>(seats_.size()), 0, 0, static_cast<int>(blocks_.size())};
    for (auto pose = slots(l); pose != slots(l + 1); ++pose) {
      seats_.push_back({*pose, s.pose_dim[*pose], group.rows});
      group.rows += s.pose_dim[*pose];
      for (auto below = pose; below != slots(l + 1); ++below) blocks_.push_back(S.Find(*below, *pose));
    }
    group.seats_end = static_cast<int>(seats_.size());
    groups_.push_back(group);
  }
}

// Poses in ranges of about equal work.
void SchurEliminator::CutShares(const BlockStructure& s, int threads) {
  std::vector<double> work(s.poses.size(), 1.0);
  double total = static_cast<double>(s.poses.size());
  int rows = 0, seats = 0;
  for (const Group& group : groups_) {
    rows = std::max(rows, group.rows);
    seats = std::max(seats, group.seats_end - group.seats_begin);
    for (int k = group.seats_begin; k < group.seats_end; ++k) {
      const Seat& seat = seats_[k];
      const double columns = 20.0 + s.landmark_dim[group.first] * (group.last - group.first);
      const double amount = columns * seat.dim * (group.rows - seat.row);
      work[seat.pose] += amount;
      total += amount;
    }
  }
  shares_.clear();
  double done = 0.0;
  for (int j = 0, begin = 0; j < static_cast<int>(s.poses.size()); ++j) {
    done += work[j];
    const bool full = done >= total / threads * static_cast<double>(shares_.size() + 1);
    if (!full && j + 1 < static_cast<int>(s.poses.size())) continue;
    const auto lda = static_cast<size_t>(Padded(rows + 1) + kRoom);
    shares_.push_back({begin, j + 1, {}, {}});
    shares_.back().A.resize(take_group_ ? SchurGroupRoom(seats) : lda * (kColumns + 8) + kernels::kOverread);
    shares_.back().C.resize(take_group_ ? 0 : lda * lda + kernels::kOverread);
    begin = j + 1;
  }
}

void SchurEliminator::Compute(BlockSystem* system, const DampingRule& rule, ThreadPool* pool) {
  pool->Run(static_cast<int>(shares_.size()), [&](int k) {
    Share& share = shares_[k];
    for (int j = share.begin; j < share.end; ++j) BeginColumn(system, j, rule);
    for (const Group& group : groups_) TakeGroup(system, group, &share);
    SymmetricBlockMatrix& S = system->S;
    for (int j = share.begin; j < share.end; ++j) Mirror(S.Dim(j), S.Values(S.ColumnBegin(j)));
  });
}

void SchurEliminator::TakeGroup(BlockSystem* system, const Group& group, Share* share) const {
  BlockSystem& y = *system;
  const BlockStructure& s = y.structure;
  const Seat *seats = seats_.data() + group.seats_begin, *seats_end = seats_.data() + group.seats_end;
  const auto seat_of = [&](int pose) {
    return std::lower_bound(seats, seats_end, pose, [](const Seat& seat, int p) { return seat.pose < p; });
  };
  const Seat *first = seat_of(share->begin), *end = seat_of(share->end);
  if (first == end) return;
  if (take_group_) {
    const auto seat = [&](const Seat* s) { return static_cast<int>(s - seats); };
    const int* blocks = blocks_.data() + group.blocks;
    const SchurGroup part{group.first, group.last, seat(seats_end), seat(first), seat(end), blocks};
    return take_group_(system, part, share->A.data());
  }

  // Rows of A from the first pose of this share on; C's columns up to its last one.
  const int top = first->row, rows = group.rows - top, lda = Padded(rows + 1) + kRoom;
  const int columns = end == seats_end ? rows + 1 : end->row - top;
  const int dim = s.landmark_dim[group.first], batch = std::max(1, kColumns / dim);
  double *A = share->A.data(), *C = share->C.data();
  for (int l = group.first; l < group.last; l += batch) {
    const int count = std::min(batch, group.last - l);
    for (int k = 0; k < count; ++k) {
      double* A_l = A + k * dim * lda;
      const double* root = &y.H_mm_root[s.landmark_block[l + k]];
      const int* block = &s.slot_block[s.landmark_slots[l + k]];
      for (const Seat* seat = first; seat != seats_end; ++seat) {
        Scale(&y.H_pm.doubles[block[seat - seats]], root, seat->dim, dim, A_l + seat->row - top, lda);
      }
      ScaleRightHandSide(root, y.b.data() + s.landmark_offset[l + k], dim, A_l + rows, lda);
    }
    const auto old = l == group.first ? kernels::Old::kForget : kernels::Old::kKeep;
    kernels::SubtractProductAAt(columns, count * dim, A, lda, C, lda, old, columns == rows + 1 ? kRoom : 0);
    if (columns < rows) {
      kernels::SubtractProductABt(rows + 1 - columns, columns, count * dim, A + columns, lda, A, lda, C + columns, lda,
                                  old);
    }
  }
  for (const Seat* b = first; b != end; ++b) {
    const auto k = static_cast<int>(b - seats), n = static_cast<int>(seats_end - seats);
    const int* block = blocks_.data() + group.blocks + k * n - k * (k - 1) / 2;
    const double* column = C + static_cast<ptrdiff_t>(b->row - top) * lda;
    for (const Seat* a = b; a != seats_end; ++a) {
      AddBlock(column + a->row - top, lda, a->dim, b->dim, y.S.Values(*block++));
    }
    double* b_schur = y.b_schur.data() + s.pose_offset[b->pose];
    for (int c = 0; c < b->dim; ++c) b_schur[c] += column[c * lda + rows];
  }
}

}  // namespace ch5
