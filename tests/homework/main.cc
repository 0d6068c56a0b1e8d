/// The main of all homework checks. It is linked as an object file: a main in the student's file is a link error.
///
///   check_problem [--submission=NAME] [--quiet] [gtest's options]
///   --submission  judges another than the linked functions
///   --quiet       gtest's printer is silent: what is printed is the student's; verdicts come by --gtest_output=json:

#include <execinfo.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <string>

#include "tests/homework/submission.h"

namespace {

// A crash ends the process; before, it says in which test, and where (as offsets, for addr2line).
void TellCrash(int signal_number) {
  std::signal(signal_number, SIG_DFL);
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  std::fprintf(stderr, "\nCRASH %s in %s\n", strsignal(signal_number), test == nullptr ? "start-up" : test->name());
  void* frames[64];
  const int depth = backtrace(frames, 64);
  backtrace_symbols_fd(frames, depth, /*stderr=*/2);
  std::raise(signal_number);
}

// Memory without bound ends in std::bad_alloc, which a test reports, and not in a machine that stands still.
void LimitMemory() {
  constexpr rlim_t kBytes = rlim_t{2} << 30;
  const rlimit limit{kBytes, kBytes};
  setrlimit(RLIMIT_AS, &limit);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::string submission = "--submission=";
    if (argument == "--quiet") {
      testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
      delete listeners.Release(listeners.default_result_printer());
    } else if (argument.rfind(submission, 0) != 0 || !ch5::homework::Choose(argument.substr(submission.size()))) {
      std::cerr << argv[0] << ": unknown option or submission " << argument << "\n";
      return 2;
    }
  }
#ifndef CH5_SANITIZED  // a sanitizer tells its own crashes, and its shadow memory has no limit
  LimitMemory();
  for (const int signal_number : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) std::signal(signal_number, &TellCrash);
#endif
  return RUN_ALL_TESTS();
}
