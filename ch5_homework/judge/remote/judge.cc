/// The judge: the stage tests, whose graded functions run in a process of their own, a fresh one for each test.
///
///   homework_judge [--seed=S] [--explains=FORMULA=CAUSE] [--time-limit=SECONDS] [--quiet] [gtest's options] -- COMMAND…
///   --seed        other random numbers and sizes than the usual ones; the same seed repeats them
///   --explains    asks whether one slip explains all answers (explains.h)
///   --time-limit  of the worker's answers in one test together, 20 s by default
///   --quiet       gtest's printer is silent: what is printed is the student's
///   COMMAND       starts a worker, in a sandbox as a rule; see worker.cc
///
/// No student's code is linked here, and nothing but numbers comes from it: a test is passed if the numbers are right.
/// Verdicts come by --gtest_output=json:FILE. Exit code 0 if all tests are passed, 1 if not, 2 for a wrong call.

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>

#include "ch5_homework/judge/explains.h"
#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/seed.h"
#include "ch5_homework/judge/values.h"

namespace ch5::homework {
namespace {

/// A worker lives as long as its test.
class OneWorkerATest : public testing::EmptyTestEventListener {
  void OnTestStart(const testing::TestInfo&) override {
    EndWorker();
    Answer::Unread() = 0;
  }
  void OnTestEnd(const testing::TestInfo& test) override {
    if (test.result()->Passed() && Answers() == 0) ADD_FAILURE() << "the test has asked the worker nothing";
    if (test.result()->Passed() && Answer::Unread() > 0) ADD_FAILURE() << "the worker has answered more than was asked";
    std::cout << EndWorker() << std::flush;
  }
};

bool TakeTimeLimit(const std::string& option, double* seconds) {
  const std::string name = "--time-limit=";
  if (option.rfind(name, 0) != 0) return false;
  char* end;
  *seconds = std::strtod(option.c_str() + name.size(), &end);
  return *end == '\0' && *seconds > 0.0 && *seconds < 1e6;
}

int Judge(int argc, char** argv, const std::vector<std::string>& command) {
  testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
  double seconds = 20.0;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--quiet") {
      delete listeners.Release(listeners.default_result_printer());
    } else if (!TakeSeed(option) && !TakeAskedCause(option) && !TakeTimeLimit(option, &seconds)) {
      std::cerr << argv[0] << ": unknown option " << option << "\n";
      return 2;
    }
  }
  GuardAgainstWorkers();
  SetWorker(command, seconds);
  listeners.Append(new OneWorkerATest);
  return RUN_ALL_TESTS();
}

}  // namespace
}  // namespace ch5::homework

int main(int argc, char** argv) {
  int own = 1;  // the arguments before "--"
  while (own < argc && std::string(argv[own]) != "--") ++own;
  const std::vector<std::string> command(argv + std::min(own + 1, argc), argv + argc);
  argv[own] = nullptr;
  argc = own;
  testing::InitGoogleTest(&argc, argv);
  if (!command.empty() || testing::GTEST_FLAG(list_tests)) return ch5::homework::Judge(argc, argv, command);
  std::cerr << argv[0] << ": which command starts a worker? …  -- COMMAND…\n";
  return 2;
}
