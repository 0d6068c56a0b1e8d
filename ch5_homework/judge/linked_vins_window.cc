/// Puts the vins_window.cc that is linked in under test.

#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

[[maybe_unused]] static const bool added = [] {
  Linked()->make_vins_term = &MakeVinsTerm<MarginalizationInfo>;
  Linked()->vins_window = {&DropSetOfMarginOld, &DropSetOfMarginSecondNew, &SlideWindow, &DetectFailure};
  return true;
}();

}  // namespace ch5::homework
