#include "ch5_homework/judge/checks/check.h"

namespace ch5::homework {

std::map<std::string, Checker>& Checks() {
  static std::map<std::string, Checker> checks;
  return checks;
}

Answer Run(const std::string& check, const Submission& submission, const Values& given) {
  Answer answer;
  try {
    const auto found = Checks().find(check);
    if (found == Checks().end()) throw WireError("there is no check " + check);
    found->second(submission, given, &answer);
  } catch (...) {
    answer.SetFailure(std::current_exception());
  }
  return answer;
}

}  // namespace ch5::homework
