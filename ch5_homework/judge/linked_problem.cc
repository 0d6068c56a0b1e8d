/// Puts the problem.cc that is linked in under test.

#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

[[maybe_unused]] static const bool added = [] {
  Linked()->make_problem = &Make<Problem>;
  Linked()->test_marginalize = &Problem::TestMarginalize;
  return true;
}();

}  // namespace ch5::homework
