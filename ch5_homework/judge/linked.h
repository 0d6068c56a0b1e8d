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
namespace gauge_prior {
inline void Link(Submission* s) { s->add_mono_ba_edges = &AddMonoBaEdges; }
}  // namespace gauge_prior
namespace gauge_freedom {
inline void Link(Submission* s) {
  s->gauge_freedom = {&GaugeNullSpace, &GaugeProjection, &GaugeMotionJacobian, &TransformCovariance};
}
}  // namespace gauge_freedom
namespace marginalization_error {
inline void Link(Submission* s) { s->make_marginalization_error = &Make<MarginalizationError, MarginalizationError>; }
}  // namespace marginalization_error
namespace vins_window {
inline void Link(Submission* s) {
  s->make_marginalization_info = &Make<MarginalizationInfo, MarginalizationInfo>;
  s->vins_window = {&DropSetOfMarginOld, &DropSetOfMarginSecondNew, &SlideWindow, &DetectFailure};
}
}  // namespace vins_window
namespace block_solver {
inline void Link(Submission* s) { s->make_block_solver = &Make<PlainBlockSolver, PlainBlockSolver>; }
}  // namespace block_solver
namespace open_tasks {
inline void Link(Submission* s) {
  s->open_tasks = {&UpdateDamping, &LinearizeProjection, &IntegrateImu, &LinearizeRange};
}
}  // namespace open_tasks

}  // namespace ch5::homework
