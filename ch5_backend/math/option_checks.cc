#include "ch5_backend/math/option_checks.h"

#include <cmath>
#include <sstream>

namespace ch5 {
namespace {

template <typename... Words>
[[noreturn]] void Refuse(const char* field, double value, const Words&... words) {
  std::ostringstream message;
  message.precision(10);
  message << field << " = " << value << ": must be ";
  (message << ... << words);
  throw OptionError(message.str());
}

}  // namespace

void CheckOption(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return;
  if (std::isinf(most)) Refuse(field, value, "at least ", least);
  Refuse(field, value, least, " to ", most);
}

void CheckPositive(const char* field, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) Refuse(field, value, "greater than 0 and finite");
}

void CheckNotNegative(const char* field, double value) {
  if (!(value >= 0.0) || !std::isfinite(value)) Refuse(field, value, "at least 0 and finite");
}

}  // namespace ch5
