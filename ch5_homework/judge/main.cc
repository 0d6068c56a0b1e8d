/// The main of all homework checks. It is linked as an object file: a main in the student's file is a link error.
///
///   check_problem [--submission=NAME] [--seed=S] [--quiet] [gtest's options]
///   --submission  judges another than the linked functions
///   --seed        other random numbers and sizes, the same for the same S
///   --quiet       gtest's printer is silent: what is printed is the student's; verdicts come by --gtest_output=json:

#include <gtest/gtest.h>

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

// Tells whoever reads what is printed in which test it is (course/homework/judge.py).
class TestBegins : public testing::EmptyTestEventListener {
  void OnTestStart(const testing::TestInfo& test) override {
    std::cout << std::flush;
    std::cerr << "\x1eTEST " << test.name() << std::endl;
  }
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (ch5::homework::TakeSeed(argument) || ch5::homework::TakeSubmission(argument)) continue;
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
