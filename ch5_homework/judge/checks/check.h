#pragma once
/// How a student's functions are called: a check calls them on its input and puts what they return into its answer.
/// It runs where the student's code does, in the process of ./course check or in the worker of ./course grade. Nothing in
/// this folder, nor in scenes/, knows what is right: all of it is linked beside the student's file, and could be called.

#include "ch5_homework/judge/submission.h"
#include "ch5_homework/judge/values.h"

namespace ch5::homework {

using Checker = void (*)(const Submission& submission, const Values& given, Answer* answer);

/// By name.
std::map<std::string, Checker>& Checks();
/// Before main.
inline bool AddChecks(const std::map<std::string, Checker>& checks) {
  Checks().insert(checks.begin(), checks.end());
  return true;
}

/// Runs one. What a function throws ends it, and is in the answer.
Answer Run(const std::string& check, const Submission& submission, const Values& given);

}  // namespace ch5::homework
