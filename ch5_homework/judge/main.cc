/// The main of all homework checks. It is linked as an object file: a main in the student's file is a link error.
///
///   check_problem [--submission=NAME] [--seed=S] [--quiet] [gtest's options]
///   --submission  judges another than the linked functions
///   --seed        other random numbers and sizes, the same for the same S
///   --quiet       gtest's printer is silent: what is printed is the student's; verdicts come by --gtest_output=json:

#include <gtest/gtest.h>

#include <cstdio>
#include <iostream>
#include <string>

#include "ch5_homework/judge/crash.h"
#include "ch5_homework/judge/seed.h"
#include "ch5_homework/judge/submission.h"

namespace {

const char* TestNow() {
  const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
  return test == nullptr ? "start-up" : test->name();
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const std::string submission = "--submission=";
    if (ch5::homework::TakeSeed(argument)) continue;
    if (argument == "--quiet") {
      testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
      delete listeners.Release(listeners.default_result_printer());
    } else if (argument.rfind(submission, 0) != 0 || !ch5::homework::Choose(argument.substr(submission.size()))) {
      std::cerr << argv[0] << ": unknown option or submission " << argument << "\n";
      return 2;
    }
  }
#ifndef CH5_SANITIZED  // a sanitizer tells its own crashes, and its shadow memory has no limit
  ch5::homework::LimitMemory();
  ch5::homework::TellCrashes(&TestNow);
#endif
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // a crash must not take the words of GCC 11's assertions along
  return RUN_ALL_TESTS();
}
