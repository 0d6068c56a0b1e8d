#pragma once
/// 5.1: InsertBlock, by which H and b₀ get `dim` rows of zeros from row `idx` on.

#include "ch5_homework/judge/right/formulas.h"

namespace ch5::homework::right {

struct OpenedTerm {
  Formula H, b;

  OpenedTerm(const MatXX& H, const VecX& b0, int idx, int dim);
};

}  // namespace ch5::homework::right
