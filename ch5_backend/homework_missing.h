#pragma once
/// What an unfilled TODO throws, so that a student reads "TODO 1.1 is not started" and never a wrong number; and, for every
/// file of the homework, the standard headers that another way to write a stage may need.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace ch5 {

class HomeworkMissing : public std::logic_error {
 public:
  /// @param todo  number and place of the TODO, such as "1.1 MakeHessian: the block's place in H"
  explicit HomeworkMissing(const std::string& todo) : std::logic_error("TODO " + todo + " is not started") {}
};

}  // namespace ch5
