#pragma once
/// What a process with a student's code does before it crashes, and that it does not take all memory.

#include <execinfo.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdio>
#include <cstring>

namespace ch5::homework {

/// Where a crash happens, for humans: a test's name, a function's.
using Where = const char* (*)();

inline Where& WhereNow() {
  static Where where = nullptr;
  return where;
}

// A crash ends the process; before, it says in which test, and where (as offsets, for addr2line).
inline void TellCrash(int signal_number) {
  std::signal(signal_number, SIG_DFL);
  std::fprintf(stderr, "\nCRASH %s in %s\n", strsignal(signal_number), WhereNow()());
  void* frames[64];
  const int depth = backtrace(frames, 64);
  backtrace_symbols_fd(frames, depth, /*stderr=*/2);
  std::raise(signal_number);
}

inline void TellCrashes(Where where) {
  WhereNow() = where;
  for (const int signal_number : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) std::signal(signal_number, &TellCrash);
}

/// Memory without bound ends in std::bad_alloc, which a test reports, and not in a machine that stands still.
inline void LimitMemory() {
  constexpr rlim_t kBytes = rlim_t{2} << 30;
  const rlimit limit{kBytes, kBytes};
  setrlimit(RLIMIT_AS, &limit);
}

}  // namespace ch5::homework
