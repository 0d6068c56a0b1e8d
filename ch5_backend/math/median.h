#pragma once
/// The middle of a set of numbers, which a few wild ones do not move.

#include <algorithm>
#include <utility>
#include <vector>

namespace ch5 {

/// The value that a fraction `share` of the values stay below.
/// @param values  at least one
/// @param share   in [0, 1)
template <typename Allocator>
double Quantile(std::vector<double, Allocator> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// @param values  at least one; of an even number the upper of the two in the middle counts
template <typename Allocator>
double Median(std::vector<double, Allocator> values) {
  return Quantile(std::move(values), 0.5);
}

/// The median of |x|, x ~ N(0, 1): of such values σ is told by theirs, divided by it.
constexpr double kMedianOfNormal = 0.6745;

}  // namespace ch5
