#pragma once
/// The student's functions, called in the worker: what Remote of functions/NAME.h puts into the Submission
/// that is under test.
/// A worker serves one test. What it throws is thrown here with the same words; see WorkerFailure for all else.

#include <string>
#include <vector>

#include "ch5_homework/judge/remote/process.h"
#include "ch5_homework/judge/remote/travel.h"

namespace ch5::homework {

/// Thrown by the student's function, in the worker.
class RemoteException : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Before the tests: how a worker is started, and how long it may take for a test. After a test that has not ended in time the
/// next ones have a tenth of it; after a worker that has not even started, none is started again.
void SetWorker(const std::vector<std::string>& command, double seconds);
/// Ends the present worker. @return what it has printed
std::string EndWorker();
/// How often the present worker has answered, with results or with an exception.
int Answers();

/// A number by which the worker knows an object again.
int NewHandle();

/// What a student's function has named and the scene does not have.
class ForeignEdge : public Edge {
 public:
  explicit ForeignEdge(std::string type) : Edge(0, {}, nullptr, nullptr), type_(std::move(type)) {}
  void ComputeResidual() override {}
  void ComputeJacobians() override {}
  std::string TypeInfo() const override { return type_; }

 private:
  std::string type_;
};

}  // namespace ch5::homework
