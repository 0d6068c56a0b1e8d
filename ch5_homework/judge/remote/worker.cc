/// The worker's main: worker_NAME [--submission=NAME]. Linked as an object: a main in the student's file is a link error.
/// Standard input has the requests and standard output takes the replies; the student's code sees neither.

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/crash.h"
#include "ch5_homework/judge/remote/travel.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

int requests = -1, replies = -1;

// Before any of the student's constructors, which may print.
__attribute__((constructor(101))) void MoveDescriptorsAndGreet() {
  requests = fcntl(0, F_DUPFD_CLOEXEC, 3);
  replies = fcntl(1, F_DUPFD_CLOEXEC, 3);
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, 0);
  dup2(2, 1);
  if (nothing > 2) close(nothing);
  WriteFrame(replies, kGreeting);
}

std::map<std::string, Handler>& Handlers() {
  static std::map<std::string, Handler> handlers;
  return handlers;
}

const char* function_now = "start-up";
const char* FunctionNow() { return function_now; }

std::string WordsOf(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an exception that is not a std::exception";
  }
}

// The answer of a check: whether it was ended by an exception, that one's words, and what it has left before.
std::string AnswerOf(const std::string& check, Reader* in) {
  Values given;
  *in >> given;
  const Answer answer = Run(check, Chosen(), given);
  std::fflush(stdout);  // what it has printed, before the judge ends this process
  const std::string words = answer.Failure() ? WordsOf(answer.Failure()) : "";
  return Pack(answer.Failure() == nullptr, words, static_cast<const Values&>(answer)).Bytes();
}

// The reply: whether the function has returned, and its results or the exception's words.
std::string ReplyTo(const std::string& request) {
  try {
    Reader in(request);
    std::string function;
    in >> function;
    if (const auto check = Checks().find(function); check != Checks().end()) {
      function_now = check->first.c_str();
      return AnswerOf(check->first, &in);
    }
    const auto handler = Handlers().find(function);
    if (handler == Handlers().end()) throw WireError("there is no function " + function);
    function_now = handler->first.c_str();
    Writer results;
    handler->second(&in, &results);
    std::fflush(stdout);  // what it has printed, before the judge ends this process
    return Pack(true).Bytes() + results.Bytes();
  } catch (const std::exception& error) {
    return Pack(false, std::string(error.what())).Bytes();
  } catch (...) {
    return Pack(false, std::string("an exception that is not a std::exception")).Bytes();
  }
}

}  // namespace

void Handle(const std::string& function, Handler handler) { Handlers()[function] = handler; }

}  // namespace ch5::homework

int main(int argc, char** argv) {
  using namespace ch5::homework;
  for (int i = 1; i < argc; ++i) {
    if (TakeSubmission(argv[i])) continue;
    std::cerr << argv[0] << ": unknown option or submission " << argv[i] << "\n";
    return 2;
  }
  PrepareForCrashes(&FunctionNow);
  for (std::string request; ReadFrame(requests, &request);) {
    if (!WriteFrame(replies, ReplyTo(request))) break;
  }
  _exit(0);  // the student's destructors have nothing to say
}
