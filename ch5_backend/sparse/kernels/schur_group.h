#pragma once
/// What a group of landmarks that the same poses see takes from S and b_S. With A_i = [H_il G_l⁻ᵀ  H_im G_m⁻ᵀ …] for the
/// landmarks l, m, … of the group:
///
///   S_ij −= A_i A_jᵀ,    b_i −= A_i [G_l⁻¹b_l; G_m⁻¹b_m; …]                    Triggs (2000), §6.1, in groups
///
/// Where the blocks have one of the fixed sizes (math/dispatch.h), block by block, each in registers while the landmarks
/// pass by. For any other sizes, also mixed, all A_i are stacked, and C = −A Aᵀ comes from a dense kernel.

#include "ch5_backend/linear/block_matrix.h"
#include "ch5_backend/math/dispatch.h"
#include "ch5_backend/sparse/kernels/landmark.h"

namespace ch5::kernels {

/// A pose that sees the landmarks of a group.
struct GroupPose {
  int pose, dim;
  int row;     ///< its first row, of those of the group's poses below each other
  int offset;  ///< its first row in b_S
};

/// The group's landmarks, one behind the other, each with the blocks of its poses.
struct GroupSystem {
  int num_landmarks, landmark_dim;
  LandmarkSlots slots;      ///< of the first landmark, which those of the others follow,
  const double* G_inverse;  ///< as its G⁻¹ does
  const double* b;          ///< all of b, and
  const int* b_offset;      ///< where each landmark's rows are in it

  const GroupPose *poses, *poses_end;
  int rows;           ///< of all poses together
  const int* blocks;  ///< their blocks of S: column by column, each from the diagonal down
};

/// The poses of a group whose columns of S are the thread's.
struct PoseRange {
  const GroupPose *begin, *end;
};

/// Subtracts a group's part from the columns of S and the rows of b_S that belong to the poses of a range.
/// @param memory  that a thread works in
using SubtractGroupFunction = void (*)(const GroupSystem&, const PoseRange&, double* memory, SymmetricBlockMatrix* S,
                                       double* b_S);

/// The one for these sizes of H_pl's blocks.
SubtractGroupFunction SubtractGroupFor(const BlockSizes& sizes);
/// The numbers of memory that it needs for groups of at most so many poses, and so many rows.
size_t GroupMemory(const BlockSizes& sizes, int poses, int rows);

}  // namespace ch5::kernels
