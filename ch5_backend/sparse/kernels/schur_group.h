#pragma once
/// The grouped variant of eliminate.h, for blocks of fixed sizes. With A_i = [H_il G_l⁻ᵀ  H_im G_m⁻ᵀ …] for the landmarks
/// l, m, … of a group:
///
///   S_ij −= A_i A_jᵀ,    b_i −= A_i [G_l⁻¹b_l; G_m⁻¹b_m; …]                    Triggs (2000), §6.1, in groups
///
/// block by block, each in registers while the landmarks pass by.

#include "ch5_backend/sparse/eliminate.h"

namespace ch5::kernels {

/// The poses of a group whose columns of S are the thread's.
struct PoseRange {
  const GroupPose *begin, *end;
};

/// Subtracts a group's part from S and b_S; `A` is memory as FixedSizeMemory says.
using SubtractGroupFunction = void (*)(const Structure&, const Linearized&, const SchurGroups&, const SchurGroup&,
                                       const PoseRange&, double* A, Eliminated*);

/// Null unless there is code for just these sizes.
SubtractGroupFunction SubtractGroupFor(const BlockSizes& sizes);
GroupMemory FixedSizeMemory(int poses, int rows);

}  // namespace ch5::kernels
