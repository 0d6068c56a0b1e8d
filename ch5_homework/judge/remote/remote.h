#pragma once
/// The student's functions, called in a worker (Ask, ask.h), which serves one test.

#include <string>
#include <vector>

#include "ch5_homework/judge/remote/process.h"

namespace ch5::homework {

/// Thrown by the student's function, in the worker; the words are the same.
class RemoteException : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Before the tests: how a worker is started, and how long it may take for a test. After a test that has not ended in time the
/// next ones have a tenth of it; after a worker that has not even started, none is started again.
void SetWorker(const std::vector<std::string>& command, double seconds);
/// Ends the present worker. @return what it has printed
std::string EndWorker();
/// How often the present worker has answered, with values or with an exception.
int Answers();

}  // namespace ch5::homework
