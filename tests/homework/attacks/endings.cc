/// Attacks that end the process, do not end at all, or leave others behind.

#include <signal.h>
#include <unistd.h>

#include <cstdlib>
#include <new>
#include <stdexcept>

#include "tests/homework/attacks/attack.h"

namespace attacks {
namespace {

volatile bool forever = true;

void Loop() {
  while (forever) {
  }
}

// Ends in silence; a child lives on, out of reach of the group, deaf to what can be ignored, with the descriptors.
void LeaveDaemon() {
  if (fork() == 0) {
    setsid();
    if (fork() != 0) _exit(0);
    for (const int number : {SIGTERM, SIGHUP, SIGINT}) signal(number, SIG_IGN);
    sleep(600);
    _exit(0);
  }
  _exit(0);
}

void LeaveManyChildren() {
  for (int k = 0; k < 20; ++k) {
    if (fork() == 0) {
      setpgid(0, 0);
      sleep(600);
      _exit(0);
    }
  }
}

int CallItself(volatile int depth) { return forever ? CallItself(depth + 1) + depth : 0; }

void EatMemory() {
  for (size_t size = 1 << 20;; size *= 2) {
    if (std::calloc(size, 1) == nullptr) throw std::bad_alloc();
  }
}

const When kStart = When::kAtStart, kFunction = When::kInFunction;
[[maybe_unused]] const bool added =
    Add("exit_in_constructor", kStart, [] { _exit(0); }) && Add("loop_in_constructor", kStart, &Loop) &&
    Add("throw_in_constructor", kStart, [] { throw std::runtime_error("never mind"); }) &&
    Add("exit_at_exit", kStart, [] { std::atexit([] { _exit(0); }); }) &&
    Add("exit", kFunction, [] { std::exit(0); }) && Add("quick_exit", kFunction, [] { std::quick_exit(0); }) &&
    Add("abort", kFunction, [] { std::abort(); }) && Add("kill_group", kFunction, [] { kill(0, SIGKILL); }) &&
    Add("crash", kFunction, [] { *reinterpret_cast<volatile int*>(8) = 1; }) && Add("loop", kFunction, &Loop) &&
    Add("stop", kFunction, [] { raise(SIGSTOP); }) && Add("daemon", kFunction, &LeaveDaemon) &&
    Add("children", kFunction, &LeaveManyChildren) && Add("memory", kFunction, &EatMemory) &&
    Add("recursion", kFunction, [] { CallItself(0); }) && Add("throw_number", kFunction, [] { throw 1; }) &&
    Add("throw_not_started", kFunction, [] { throw std::logic_error("TODO 1.1a is not started"); });

}  // namespace
}  // namespace attacks
