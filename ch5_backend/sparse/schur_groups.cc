#include "ch5_backend/sparse/schur_groups.h"

#include <algorithm>

namespace ch5 {
namespace {

// Sorted as they are, landmarks that the same poses see stand side by side.
void FindGroups(const Structure& s, const SymmetricBlockMatrix& S, SchurGroups* found) {
  const auto slots = [&](int l) { return s.slot_pose.begin() + s.landmark_slots[l]; };
  for (int l = 0; l < s.NumLandmarks(); ++l) {
    const bool same = l > 0 && s.landmark_dim[l] == s.landmark_dim[l - 1] &&
                      std::equal(slots(l), slots(l + 1), slots(l - 1), slots(l));
    if (same) {
      found->groups.back().last = l + 1;
      continue;
    }
    const int first_pose = static_cast<int>(found->poses.size()), first_block = static_cast<int>(found->blocks.size());
    SchurGroup group{l, l + 1, first_pose, first_pose, 0, first_block};
    for (auto pose = slots(l); pose != slots(l + 1); ++pose) {
      found->poses.push_back({*pose, s.pose_dim[*pose], group.rows});
      group.rows += s.pose_dim[*pose];
      for (auto below = pose; below != slots(l + 1); ++below) found->blocks.push_back(S.Find(*below, *pose));
    }
    group.poses_end = static_cast<int>(found->poses.size());
    found->groups.push_back(group);
  }
}

// The multiplications that each column of S costs, about.
std::vector<double> WorkOfColumns(const Structure& s, const SchurGroups& found) {
  std::vector<double> work(s.poses.size(), 1.0);
  for (const SchurGroup& group : found.groups) {
    const double columns = 20.0 + s.landmark_dim[group.first] * (group.last - group.first);
    for (int k = group.poses_begin; k < group.poses_end; ++k) {
      const GroupPose& pose = found.poses[k];
      work[pose.pose] += columns * pose.dim * (group.rows - pose.row);
    }
  }
  return work;
}

}  // namespace

SchurGroups FindSchurGroups(const Structure& s, const SymmetricBlockMatrix& S, int threads,
                            GroupMemory (*memory)(int poses, int rows)) {
  SchurGroups found;
  FindGroups(s, S, &found);
  int rows = 0, poses = 0;
  for (const SchurGroup& group : found.groups) {
    rows = std::max(rows, group.rows);
    poses = std::max(poses, group.poses_end - group.poses_begin);
  }
  const GroupMemory size = memory(poses, rows);
  const std::vector<double> work = WorkOfColumns(s, found);
  double total = 0.0, done = 0.0;
  for (const double amount : work) total += amount;
  for (int j = 0, begin = 0; j < s.NumPoses(); ++j) {
    done += work[j];
    const bool full = done >= total / threads * static_cast<double>(found.ranges.size() + 1);
    if (!full && j + 1 < s.NumPoses()) continue;
    found.ranges.push_back({begin, j + 1, AlignedVector(size.A), AlignedVector(size.C)});
    begin = j + 1;
  }
  return found;
}

std::pair<const GroupPose*, const GroupPose*> SchurGroups::PosesIn(const SchurGroup& group,
                                                                   const ColumnRange& range) const {
  const GroupPose *begin = poses.data() + group.poses_begin, *end = poses.data() + group.poses_end;
  const auto first_from = [&](int pose) {
    return std::lower_bound(begin, end, pose, [](const GroupPose& a, int p) { return a.pose < p; });
  };
  return {first_from(range.begin), first_from(range.end)};
}

std::vector<std::vector<int>> SchurPattern(const Structure& s) {
  std::vector<std::vector<int>> pattern = s.H_pp_pattern;
  std::vector<int> last_column_of(s.poses.size(), -1);
  for (int j = 0; j < static_cast<int>(s.poses.size()); ++j) {
    std::vector<int>& rows = pattern[j];
    for (const int i : rows) last_column_of[i] = j;
    for (int k = s.pose_slots_begin[j]; k < s.pose_slots_begin[j + 1]; ++k) {
      const int slot = s.pose_slots[k];
      for (int other = slot + 1; other < s.landmark_slots[s.slot_landmark[slot] + 1]; ++other) {
        const int i = s.slot_pose[other];
        if (last_column_of[i] == j) continue;
        last_column_of[i] = j;
        rows.push_back(i);
      }
    }
    std::sort(rows.begin(), rows.end());
  }
  return pattern;
}

}  // namespace ch5
