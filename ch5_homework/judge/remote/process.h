#pragma once
/// The process that holds the student's code, seen from the judge.

#include <sys/types.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <vector>

namespace ch5::homework {

/// What a failure before the first call has happened in.
constexpr char kItsStart[] = "its start";

/// The worker gave no answer. The words begin with one of
///   START     it did not greet: the command, or the sandbox, is to blame, not the student's code as a rule
///   CRASH     a signal ended it; its name follows
///   EXIT      it ended by itself, or closed its side; the exit code follows
///   TIMEOUT   it did not answer in time
/// What is no reply is a WireError, whose words begin with GARBAGE.
class WorkerFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// From now on, processes whose parents have ended are given to this one, which ends them with the worker; and its memory
/// cannot be opened by a worker of the same user, unless that is root.
void GuardAgainstWorkers();

class WorkerProcess {
 public:
  /// Starts the command in a process group of its own, without any descriptor but its standard ones: 0 for requests, 1 for
  /// replies, and 2 for what it prints.  @param seconds  that it may take in all, for all its replies
  /// @throws WorkerFailure if it cannot be started
  WorkerProcess(const std::vector<std::string>& command, double seconds);
  /// Ends it and all that it has started.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  /// Sends a request and waits for the reply.  @param what  the request in words, for failures
  /// @throws WorkerFailure
  /// @throws WireError
  std::string Ask(const std::string& request, const std::string& what);

  /// What it has printed so far, its beginning only.
  const std::string& Printed();

 private:
  void Start(const std::vector<std::string>& command);
  /// Waits for the greeting.
  void Meet();
  /// Waits until something can be read or written.
  void Wait(bool writing, const std::string& what);
  void Send(const std::string& frame, size_t* sent);
  /// @return false at the end of the replies
  bool Receive();
  void TakePrinted();
  /// How it ended, in words.
  std::string HowEnded(const std::string& what);
  bool HasEnded(int* status);

  pid_t pid_ = -1;
  bool waited_for_ = false, has_greeted_ = false;
  int requests_ = -1, replies_ = -1, prints_ = -1;
  double seconds_;
  std::chrono::steady_clock::time_point deadline_;
  std::string received_, printed_;
};

}  // namespace ch5::homework
