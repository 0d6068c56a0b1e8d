#pragma once
/// What structs of options check themselves with: each has a Validate(), which the class that takes the options calls.

#include <limits>
#include <stdexcept>

namespace ch5 {

/// An option that cannot be used; the message names the field and its value.
class OptionError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// @param field  such as "VinsOptions::window_size"
/// @throws OptionError unless least ≤ value ≤ most; NaN is refused
void CheckOption(const char* field, double value, double least, double most = std::numeric_limits<double>::infinity());

/// @throws OptionError unless the value is finite and greater than zero, or not less than zero
void CheckPositive(const char* field, double value);
void CheckNotNegative(const char* field, double value);

}  // namespace ch5
