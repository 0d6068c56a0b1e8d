/// The worker's main: worker_NAME [--submission=NAME]. Linked as an object: a main in the student's file is a link error.
/// Standard input has the questions and standard output takes the replies; the student's code sees neither.

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/crash.h"
#include "ch5_homework/judge/remote/wire.h"

namespace ch5::homework {
namespace {

int questions = -1, replies = -1;

// Before any of the student's constructors, which may print.
__attribute__((constructor(101))) void MoveDescriptorsAndGreet() {
  questions = fcntl(0, F_DUPFD_CLOEXEC, 3);
  replies = fcntl(1, F_DUPFD_CLOEXEC, 3);
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, 0);
  dup2(2, 1);
  if (nothing > 2) close(nothing);
  WriteFrame(replies, kGreeting);
}

std::string check_now = "start-up";
const char* CheckNow() { return check_now.c_str(); }

std::string WordsOf(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an exception that is not a std::exception";
  }
}

std::string ReplyWith(const Answer& answer) {
  Writer reply;
  reply.Int(answer.Failure() == nullptr);
  reply.String(answer.Failure() ? WordsOf(answer.Failure()) : "");
  reply.All(answer);
  if (reply.Bytes().size() > kMaxFrame)
    throw WireError("an answer of " + std::to_string(reply.Bytes().size()) + " bytes");
  return reply.Bytes();
}

std::string ReplyTo(const std::string& question) {
  try {
    Reader in(question);
    Values given;
    check_now = in.String();
    in.All(&given);
    const Answer answer = Run(check_now, Chosen(), given);
    std::fflush(stdout);  // what it has printed, before the judge ends this process
    return ReplyWith(answer);
  } catch (...) {
    Answer none;
    none.SetFailure(std::current_exception());
    return ReplyWith(none);
  }
}

}  // namespace
}  // namespace ch5::homework

int main(int argc, char** argv) {
  using namespace ch5::homework;
  for (int i = 1; i < argc; ++i) {
    if (TakeSubmission(argv[i])) continue;
    std::cerr << argv[0] << ": unknown option or submission " << argv[i] << "\n";
    return 2;
  }
  PrepareForCrashes(&CheckNow);
  for (std::string question; ReadFrame(questions, &question);) {
    if (!WriteFrame(replies, ReplyTo(question))) break;
  }
  _exit(0);  // the student's destructors have nothing to say
}
