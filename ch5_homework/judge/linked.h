#pragma once
/// NAME::Link puts the functions of the NAME.cc that is linked in under test: one for each of the students' files.

#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

namespace problem {
inline void Link(Submission* s) {
  s->make_problem = &Make<Problem, Problem>;
  s->test_marginalize = &Problem::TestMarginalize;
}
}  // namespace problem
namespace marginalization_error {
inline void Link(Submission* s) { s->make_marginalization_error = &Make<MarginalizationError, MarginalizationError>; }
}  // namespace marginalization_error
namespace block_solver {
inline void Link(Submission* s) { s->make_block_solver = &Make<PlainBlockSolver, PlainBlockSolver>; }
}  // namespace block_solver

}  // namespace ch5::homework
