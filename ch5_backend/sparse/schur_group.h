#pragma once
/// What a group of landmarks that the same poses see takes from S, where the blocks' sizes are known at compile time.
///
/// With H_ll⁻¹ = G⁻ᵀG⁻¹ and A_i = [H_il G_l⁻ᵀ  H_im G_m⁻ᵀ …] for the landmarks l, m, … of the group:
///
///   S_ij −= A_i A_jᵀ,    b_i −= A_i [G_l⁻¹b_l; G_m⁻¹b_m; …]
///
/// block by block, each in registers while the landmarks pass by.

#include "ch5_backend/sparse/block_passes.h"

namespace ch5 {

/// A group, and the part of it that one thread does.
struct SchurGroup {
  int first, last;           ///< landmarks
  int seats;                 ///< poses that see them
  int first_seat, end_seat;  ///< whose columns of S are the thread's
  const int* blocks;         ///< S's blocks that the group changes: column by column, each from the diagonal down
};

/// Takes a group from S and b_schur; `A` is memory for SchurGroupRoom(seats) numbers.
using TakeSchurGroup = void (*)(BlockSystem*, const SchurGroup&, double* A);

/// For these dimensions, H_pm's precision and this processor; null unless the dimensions have code of their own.
TakeSchurGroup SchurGroupFor(int pose_dim, int landmark_dim, bool single_precision);
size_t SchurGroupRoom(int seats);

}  // namespace ch5
