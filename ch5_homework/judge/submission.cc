#include "ch5_homework/judge/submission.h"

#include <map>

namespace ch5::homework {
namespace {

std::map<std::string, Submission>& Registered() {
  static std::map<std::string, Submission> submissions{{"linked", {}}};
  return submissions;
}

const Submission*& Current() {
  static const Submission* current = &Registered().at("linked");
  return current;
}

}  // namespace

const Submission& Chosen() { return *Current(); }

bool TakeSubmission(const std::string& option) {
  const std::string name = "--submission=";
  if (option.rfind(name, 0) != 0) return false;
  const auto it = Registered().find(option.substr(name.size()));
  if (it != Registered().end()) Current() = &it->second;
  return it != Registered().end();
}

Submission* Linked() { return &Registered().at("linked"); }

bool Register(const std::string& name, const Submission& submission) {
  return Registered().emplace(name, submission).second;
}

}  // namespace ch5::homework
