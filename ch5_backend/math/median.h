#pragma once
/// The middle of a set of numbers, which a few wild ones do not move.

#include <algorithm>
#include <vector>

namespace ch5 {

/// @param values  at least one; of an even number the upper of the two in the middle counts
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace ch5
