#pragma once
/// What an unfilled TODO throws, so that a student reads "TODO 1.1 is not started" and never a wrong number.

#include <stdexcept>
#include <string>

namespace ch5 {

class HomeworkMissing : public std::logic_error {
 public:
  /// @param todo  number and place of the TODO, such as "1.1 MakeHessian: the block's place in H"
  explicit HomeworkMissing(const std::string& todo) : std::logic_error("TODO " + todo + " is not started") {}
};

}  // namespace ch5
