#pragma once
/// Does a slip in a formula explain all wrong answers, or the first one by coincidence?

#include <string>

namespace ch5::homework {

/// Takes "--explains=FORMULA=CAUSE", of an earlier run's diagnosis: then no wrong answer fails, and a test's report has the
/// property "refuted" if an answer is not what this slip in this formula gives (diagnosis.cc). Numbers in the cause, which is
/// JSON, may be others in another call.
bool TakeAskedCause(const std::string& option);

}  // namespace ch5::homework
