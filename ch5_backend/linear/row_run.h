#pragma once
/// How the rows of a child's U lie in its parent's front.

namespace ch5 {

/// Consecutive rows of U that are consecutive in the parent's front too.
struct RowRun {
  int from, to, length;
};

/// target += source. Runs are a few blocks long: too short for a library call, long enough for two numbers at a time.
inline void Add(const double* source, int length, double* target) {
  typedef double Two __attribute__((vector_size(16), aligned(8), may_alias));
  int i = 0;
  for (; i + 2 <= length; i += 2) {
    *reinterpret_cast<Two*>(target + i) += *reinterpret_cast<const Two*>(source + i);
  }
  if (i < length) target[i] += source[i];
}

}  // namespace ch5
