#pragma once
/// Crash reporting and a memory limit for processes that run a student's code.

#include <execinfo.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <initializer_list>

namespace ch5::homework {

constexpr rlim_t kMemory = rlim_t{2} << 30;  // bytes of addresses

/// Where a crash happens, for humans: a test's name, a function's.
using Where = const char* (*)();

inline Where& WhereNow() {
  static Where where = nullptr;
  return where;
}

/// An address near the beginning of the stack, which grows downwards.
inline std::uintptr_t& StackBegin() {
  static std::uintptr_t address = 0;
  return address;
}

// No access within the stack's own addresses fails before the stack has reached its limit, or a frame has leapt over it.
inline bool IsStackOverflow(int signal_number, const void* fault) {
  constexpr std::uintptr_t kLeap = 1 << 20;
  const auto address = reinterpret_cast<std::uintptr_t>(fault);
  rlimit size{};
  getrlimit(RLIMIT_STACK, &size);
  return signal_number == SIGSEGV && address < StackBegin() &&
         StackBegin() - address < std::min(size.rlim_cur, kMemory) + kLeap;
}

// Each member of an object at address 0 lies on the first pages. A wild address may be reported as 0, too.
inline bool IsNullPointer(int signal_number, const siginfo_t& info) {
  return signal_number == SIGSEGV && info.si_code == SEGV_MAPERR &&
         reinterpret_cast<std::uintptr_t>(info.si_addr) < std::uintptr_t{1} << 16;
}

inline const char* NameOfCrash(int signal_number, const siginfo_t& info) {
  if (IsStackOverflow(signal_number, info.si_addr)) return "Stack overflow";
  return IsNullPointer(signal_number, info) ? "Null pointer" : strsignal(signal_number);
}

// A crash ends the process; before, it says in which test, and where (as offsets, for addr2line).
inline void TellCrash(int signal_number, siginfo_t* info, void*) {
  std::signal(signal_number, SIG_DFL);
  std::fprintf(stderr, "\nCRASH %s in %s\n", NameOfCrash(signal_number, *info), WhereNow()());
  void* frames[64];
  const int depth = backtrace(frames, 64);
  backtrace_symbols_fd(frames, depth, /*stderr=*/2);
  std::raise(signal_number);
}

inline void TellCrashes(Where where) {
  static char spare[1 << 16];  // a stack for the handler that reports a full stack
  WhereNow() = where;
  StackBegin() = reinterpret_cast<std::uintptr_t>(&where);
  stack_t stack{};
  stack.ss_sp = spare;
  stack.ss_size = sizeof(spare);
  sigaltstack(&stack, nullptr);
  struct sigaction action {};
  action.sa_sigaction = &TellCrash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  void* frames[1];
  backtrace(frames, 1);  // loads what it needs now, since a signal may come within malloc
  // SIGTERM comes when the time is over: this then reports which loop does not end.
  for (const int signal_number : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGTERM}) {
    sigaction(signal_number, &action, nullptr);
  }
}

/// Unbounded allocation ends in std::bad_alloc, which a test reports, and not in a frozen machine.
inline void LimitMemory() {
  const rlimit limit{kMemory, kMemory};
  setrlimit(RLIMIT_AS, &limit);
}

/// To be called by main.
inline void PrepareForCrashes([[maybe_unused]] Where where) {
#ifndef CH5_SANITIZED  // a sanitizer reports crashes itself, and its shadow memory has no limit
  LimitMemory();
  TellCrashes(where);
#endif
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // a crash must not take the words of GCC 11's assertions along
}

}  // namespace ch5::homework
