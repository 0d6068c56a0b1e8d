#pragma once
/// S = H_pp + λD − Σ_l H_pl H_ll⁻¹ H_plᵀ  and  b_p − Σ_l H_pl H_ll⁻¹ b_l, group by group.
///
/// Landmarks that the same poses see change the same blocks of S. With H_ll⁻¹ = G⁻ᵀG⁻¹, a group's part is one product
///
///          ┌ H_1l G_l⁻ᵀ │ H_1m G_m⁻ᵀ │ … ┐    a row of blocks for each pose, a column for each landmark of the group,
///      A = │ H_2l G_l⁻ᵀ │ H_2m G_m⁻ᵀ │ … │    and the right-hand side as the last row:
///          └ (G_l⁻¹b_l)ᵀ│ (G_m⁻¹b_m)ᵀ│ … ┘    C = A Aᵀ, of which the lower half is needed
///
/// that a dense kernel computes; then C's blocks are taken from S. Where the blocks' sizes are known at compile time,
/// C is not formed at all, see schur_group.h.
/// Each thread owns a range of S's columns and walks all groups, so every block is summed in the same order for any
/// number of threads, in one copy of S.

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/sparse/schur_group.h"

namespace ch5 {

class SchurEliminator {
 public:
  /// Finds the groups, S's blocks that they change, and the threads' shares; takes all memory.
  /// @param S  has its pattern
  /// @param take_group  for the dimensions of all blocks that landmarks meet, or null
  void Prepare(const BlockStructure& structure, const SymmetricBlockMatrix& S, int threads, TakeSchurGroup take_group);

  /// Fills S, b_schur and scale from H_pp, H_pm, H_mm_root and b.
  void Compute(BlockSystem* system, const DampingRule& rule, ThreadPool* pool);

 private:
  struct Seat {  // of a pose in its group
    int pose, dim, row;
  };
  struct Group {
    int first, last;             // landmarks
    int seats_begin, seats_end;  // by ascending pose
    int rows;                    // of all poses together
    int blocks;  // where its blocks of S begin in blocks_: column by column, each from the diagonal down
  };
  struct Share {
    int begin, end;  // poses, whose columns of S are the thread's
    AlignedVector A, C;
  };

  void FindGroups(const BlockStructure& structure, const SymmetricBlockMatrix& S);
  void CutShares(const BlockStructure& structure, int threads);
  void TakeGroup(BlockSystem* system, const Group& group, Share* share) const;

  TakeSchurGroup take_group_ = nullptr;
  std::vector<Group> groups_;
  std::vector<Seat> seats_;
  std::vector<int> blocks_;
  std::vector<Share> shares_;
};

}  // namespace ch5
