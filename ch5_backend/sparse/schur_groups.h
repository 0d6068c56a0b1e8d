#pragma once
/// Landmarks that the same poses see, together: they change the same blocks of S. Found once for a structure.

#include <utility>

#include "ch5_backend/sparse/structure.h"

namespace ch5 {

/// A pose that sees the landmarks of a group.
struct GroupPose {
  int pose, dim;
  int row;  ///< its first row, of those of the group's poses below each other
};

/// Consecutive landmarks that the same poses see.
struct SchurGroup {
  int first, last;             ///< landmarks
  int poses_begin, poses_end;  ///< in SchurGroups::poses, by ascending number
  int rows;                    ///< of all poses together
  int blocks_begin;  ///< its blocks of S in SchurGroups::blocks: column by column, each from the diagonal down
};

struct SchurGroups {
  std::vector<SchurGroup> groups;
  std::vector<GroupPose> poses;
  std::vector<int> blocks;

  /// The columns of S that are one thread's work, poses [begin, end), and the memory that it works in.
  struct ColumnRange {
    int begin, end;
    AlignedVector A, C;
  };
  std::vector<ColumnRange> ranges;  ///< of about equal work

  /// The poses of a group whose columns are in a range, [first, second).
  std::pair<const GroupPose*, const GroupPose*> PosesIn(const SchurGroup& group, const ColumnRange& range) const;
};

/// The memory that a thread needs for its groups, in numbers.
struct GroupMemory {
  size_t A, C;
};

/// @param S        has its pattern
/// @param threads  for which the columns are cut into ranges
/// @param memory   for groups of at most so many poses, and so many rows
SchurGroups FindSchurGroups(const Structure& structure, const SymmetricBlockMatrix& S, int threads,
                            GroupMemory (*memory)(int poses, int rows));

/// Rows i ≥ j of each column of S, which ties all poses that see one landmark.
std::vector<std::vector<int>> SchurPattern(const Structure& structure);

}  // namespace ch5
