/// The worker's main: worker_NAME [--submission=NAME]. Linked as an object: a main in the student's file is a link error.
/// Standard input has the questions and standard output takes the replies; the student's code sees neither.

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <iostream>

#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/crash.h"
#include "ch5_homework/judge/remote/wire.h"

namespace ch5::homework {
namespace {

// By its number: a submission may have functions with the names of those of the C library.
long Call(long number, long a, long b, const void* c) {
#if defined(__x86_64__)
  long result = number;
  asm volatile("mov $0, %%r10\n\tmov $0, %%r8\n\tsyscall"
               : "+a"(result)
               : "D"(a), "S"(b), "d"(c)
               : "rcx", "r8", "r10", "r11", "memory");
  return result;
#elif defined(__aarch64__)
  register long x0 asm("x0") = a, x1 asm("x1") = b, x3 asm("x3") = 0, x4 asm("x4") = 0, x8 asm("x8") = number;
  register const void* x2 asm("x2") = c;
  asm volatile("svc 0" : "+r"(x0) : "r"(x1), "r"(x2), "r"(x3), "r"(x4), "r"(x8) : "memory");
  return x0;
#else
  return syscall(number, a, b, c, 0, 0);
#endif
}

// The loader has mapped all code by now, and nothing of the submission has run. From here on no page becomes code, not even one of
// the program's own file, which has the submission's constants, too. The sandbox forbids the rest.
void ForbidMoreCode() {
  sock_filter rules[] = {BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
                         BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_mmap, 0, 3),
                         BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args[2])),
                         BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, PROT_EXEC, 0, 1),
                         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM),
                         BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW)};
  const sock_fprog filter{sizeof(rules) / sizeof(rules[0]), rules};
  Call(SYS_prctl, PR_SET_NO_NEW_PRIVS, 1, nullptr);
  Call(SYS_seccomp, SECCOMP_SET_MODE_FILTER, 0, &filter);
}
[[gnu::section(".preinit_array"), gnu::used]] void (*const before_all_constructors)() = &ForbidMoreCode;

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
