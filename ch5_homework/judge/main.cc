/// The main of all homework checks. It is linked as an object file: a main in the student's file is a link error.
///
///   check_problem [--submission=NAME] [--seed=S] [--explains=FORMULA=CAUSE] [--quiet] [gtest's options]
///   --submission  judges another than the linked functions
///   --seed        other random numbers and sizes; the same seed repeats them
///   --explains    asks whether one slip explains all answers (explains.h)
///   --quiet       gtest's printer is silent: what is printed is the student's; verdicts come by --gtest_output=json:

#include <dlfcn.h>
#include <execinfo.h>
#include <gtest/gtest.h>

#include <iostream>
#include <string>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/crash.h"
#include "ch5_homework/judge/explains.h"

namespace {

const char* TestNow() {
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  return test == nullptr ? "start-up" : test->name();
}

constexpr int kDeepest = 64;

// The calls that led to the last exception of a test.
struct Thrown {
  int depth = 0;
  void* calls[kDeepest];
};
thread_local Thrown thrown;

// Tells the reader of the output which test is running, and where an exception ended it (course/homework/judge.py).
class TestBegins : public testing::EmptyTestEventListener {
  void OnTestStart(const testing::TestInfo& test) override {
    thrown.depth = 0;
    std::cout << std::flush;
    std::cerr << "\x1eTEST " << test.name() << std::endl;
  }

  void OnTestEnd(const testing::TestInfo& test) override {
    if (!test.result()->Failed() || thrown.depth == 0) return;
    std::cout << std::flush;
    std::cerr << "\x1eTHROWN";
    for (int k = 0; k < thrown.depth; ++k) {
      Dl_info file{};
      if (dladdr(thrown.calls[k], &file) == 0) continue;
      const std::string name = file.dli_fname;
      std::cerr << " " << name.substr(name.rfind('/') + 1) << "(+0x" << std::hex
                << static_cast<char*>(thrown.calls[k]) - static_cast<char*>(file.dli_fbase) << std::dec << ")";
    }
    std::cerr << std::endl;
  }
};

}  // namespace

#ifndef CH5_SANITIZED  // whose library has its own
/// In place of the C++ library's, which it calls: remembers where an exception begins. Its headers declare that function in
/// more than one way.
using Throw = void(void* object, void* type, void (*destroy)(void*));
extern "C" [[noreturn]] Throw RememberThrow __asm__("__cxa_throw");
extern "C" void RememberThrow(void* object, void* type, void (*destroy)(void*)) {
  static Throw* const library = reinterpret_cast<Throw*>(dlsym(RTLD_NEXT, "__cxa_throw"));
  thrown.depth = backtrace(thrown.calls, kDeepest);
  library(object, type, destroy);
  __builtin_unreachable();
}
#endif

ch5::homework::Answer ch5::homework::Ask(const std::string& check, const Values& given) {
  return Run(check, Chosen(), given);
}

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    using namespace ch5::homework;
    if (TakeSeed(argument) || TakeSubmission(argument) || TakeAskedCause(argument)) continue;
    if (argument == "--quiet") {
      testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
      delete listeners.Release(listeners.default_result_printer());
      listeners.Append(new TestBegins);
    } else {
      std::cerr << argv[0] << ": unknown option or submission " << argument << "\n";
      return 2;
    }
  }
  ch5::homework::PrepareForCrashes(&TestNow);
  return RUN_ALL_TESTS();
}
