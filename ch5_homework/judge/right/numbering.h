#pragma once
/// 6b: the first rows of all blocks, in order of id, then m and n: how often each block is counted there, times the sizes.

#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework::right {

struct Numbering {
  Formula rows;

  /// @param parameters  how many numbers a block has, which may be more than its size
  Numbering(const VecX& sizes, const VecX& parameters, const std::vector<bool>& dropped);
};

}  // namespace ch5::homework::right
