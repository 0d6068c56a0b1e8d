#pragma once
/// The student's functions, called in the worker: what remote_NAME.cc puts into the Submission that is under test.
/// A worker serves one test. What it throws is thrown here with the same words; see WorkerFailure for all else.

#include <string>
#include <vector>

#include "ch5_homework/judge/remote/graph_wire.h"
#include "ch5_homework/judge/remote/process.h"

namespace ch5::homework {

/// Thrown by the student's function, in the worker.
class RemoteException : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Before the tests: how a worker is started, and how long it may take for a test.
void SetWorker(const std::vector<std::string>& command, double seconds);
/// Ends the present worker. @return what it has printed
std::string EndWorker();
/// How often the present worker has answered, with results or with an exception.
int Answers();

/// Calls a function of the worker. @return its results
/// @throws WorkerFailure, RemoteException
Reader Call(const std::string& function, const Writer& arguments);

/// The same, with all the results. @throws WorkerFailure, also if they do not fit; RemoteException
template <typename... R>
void Ask(const std::string& function, const Writer& arguments, R*... results) {
  Reader reply = Call(function, arguments);
  try {
    Unpack(&reply, results...);
    reply.End();
  } catch (const WireError& error) {
    throw WorkerFailure("GARBAGE in the reply to " + function + ": " + error.what());
  }
}

/// A number by which the worker knows an object again.
int NewHandle();

}  // namespace ch5::homework
