#include "ch5_homework/judge/remote/process.h"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>

#include "ch5_homework/judge/remote/wire.h"

namespace ch5::homework {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr size_t kMaxPrinted = 1 << 16;  // bytes that are kept of what a worker prints
constexpr auto kGrace = 500ms;           // for a worker that has closed its side to end

void Close(int* descriptor) {
  if (*descriptor >= 0) close(*descriptor);
  *descriptor = -1;
}

// In the child, between fork and exec. @param standard  what becomes 0, 1 and 2
[[noreturn]] void Become(const std::vector<char*>& command, const int (&standard)[3]) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (int k = 0; k < 3; ++k) dup2(standard[k], k);  // all of them are greater than 2
  if (syscall(SYS_close_range, 3u, ~0u, 0u) != 0) {
    for (int k = 3; k < 1024; ++k) close(k);
  }
  std::signal(SIGPIPE, SIG_DFL);
  execvp(command[0], command.data());
  const std::string words = std::string(command[0]) + ": " + std::strerror(errno) + "\n";
  if (write(2, words.data(), words.size()) < 0) _exit(126);
  _exit(127);
}

// A pipe whose ends are greater than 2, whatever was closed before the judge was started.
void MakePipe(int* read_end, int* write_end) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw WorkerFailure(std::string("EXIT no pipe: ") + std::strerror(errno));
  *read_end = fcntl(ends[0], F_DUPFD_CLOEXEC, 3);
  *write_end = fcntl(ends[1], F_DUPFD_CLOEXEC, 3);
  close(ends[0]);
  close(ends[1]);
}

// The parent's id comes after the name in brackets, which may contain anything, and the state. −1 if it has ended.
pid_t ParentOf(const std::string& process) {
  char text[512] = "";
  const int file = open(("/proc/" + process + "/stat").c_str(), O_RDONLY | O_CLOEXEC);
  const bool was_read = file >= 0 && read(file, text, sizeof(text) - 1) > 0;
  if (file >= 0) close(file);
  const char* end = was_read ? std::strrchr(text, ')') : nullptr;
  pid_t parent = -1;
  return end != nullptr && std::sscanf(end, ") %*c %d", &parent) == 1 ? parent : -1;
}

std::vector<pid_t> Children() {
  std::vector<pid_t> children;
  DIR* folder = opendir("/proc");
  if (folder == nullptr) return children;
  while (const dirent* entry = readdir(folder)) {
    const std::string name = entry->d_name;
    if (name.find_first_not_of("0123456789") == std::string::npos && ParentOf(name) == getpid()) {
      children.push_back(static_cast<pid_t>(std::atoi(name.c_str())));
    }
  }
  closedir(folder);
  return children;
}

// The worker's own children have become ours when it ended; theirs will.
void EndChildren() {
  const auto deadline = Clock::now() + 2s;
  for (auto children = Children(); !children.empty() && Clock::now() < deadline; children = Children()) {
    for (const pid_t child : children) kill(child, SIGKILL);
    for (const pid_t child : children) waitpid(child, nullptr, 0);
  }
}

std::string InWords(int status, const std::string& what) {
  int signal_number = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  if (code > 128 && code < 128 + NSIG) signal_number = code - 128;  // as shells and sandboxes pass it on
  if (signal_number != 0) return std::string("CRASH ") + strsignal(signal_number) + " in " + what;
  return "EXIT " + std::to_string(code) + " in " + what;
}

}  // namespace

void GuardAgainstWorkers() {
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  prctl(PR_SET_DUMPABLE, 0);
  std::signal(SIGPIPE, SIG_IGN);
}

WorkerProcess::WorkerProcess(const std::vector<std::string>& command, double seconds)
    : seconds_(seconds),
      deadline_(Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds))) {
  Start(command);
}

void WorkerProcess::Start(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  int standard[3];
  MakePipe(&standard[0], &requests_);
  MakePipe(&replies_, &standard[1]);
  MakePipe(&prints_, &standard[2]);
  pid_ = fork();
  if (pid_ == 0) Become(arguments, standard);
  for (int& descriptor : standard) Close(&descriptor);
  if (pid_ < 0) throw WorkerFailure(std::string("EXIT no process: ") + std::strerror(errno));
  setpgid(pid_, pid_);
  for (const int descriptor : {requests_, replies_, prints_}) fcntl(descriptor, F_SETFL, O_NONBLOCK);
}

WorkerProcess::~WorkerProcess() {
  if (pid_ > 0 && !waited_for_) {
    kill(-pid_, SIGKILL);
    kill(pid_, SIGKILL);  // if it has left its group
    waitpid(pid_, nullptr, 0);
  }
  for (int* descriptor : {&requests_, &replies_, &prints_}) Close(descriptor);
  EndChildren();
}

void WorkerProcess::Meet() {
  for (bool more = true; !has_greeted_; more = Receive()) {
    if (const auto greeting = TakeFrame(&received_)) {
      if (*greeting != kGreeting) throw WireError("no greeting");
      has_greeted_ = true;
      return;
    }
    if (!more) throw WorkerFailure("START: " + HowEnded(kItsStart));
    Wait(false, kItsStart);
    TakePrinted();
  }
}

std::string WorkerProcess::Ask(const std::string& request, const std::string& what) {
  Meet();
  Receive();
  if (!received_.empty()) throw WireError("a reply before " + what + " was asked for");
  const std::string frame = Framed(request);
  size_t sent = 0;
  for (;;) {
    Wait(sent < frame.size(), what);
    TakePrinted();
    if (sent < frame.size()) Send(frame, &sent);
    const bool more = Receive();
    if (auto reply = TakeFrame(&received_)) {
      if (received_.empty()) return *reply;
      throw WireError("more behind the reply to " + what);
    }
    if (!more) throw WorkerFailure(HowEnded(what));
  }
}

void WorkerProcess::Wait(bool writing, const std::string& what) {
  pollfd descriptors[] = {{writing ? requests_ : -1, POLLOUT, 0}, {replies_, POLLIN, 0}, {prints_, POLLIN, 0}};
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
  const int ready = left <= 0 ? 0 : poll(descriptors, 3, static_cast<int>(std::min<long>(left + 1, 1 << 20)));
  if (ready > 0 || (ready < 0 && errno == EINTR)) return;
  if (Clock::now() < deadline_) return;
  std::ostringstream words;
  words << (has_greeted_ ? "" : "START: ") << "TIMEOUT after " << seconds_ << " s in " << what;
  throw WorkerFailure(words.str());
}

void WorkerProcess::Send(const std::string& frame, size_t* sent) {
  const ssize_t wrote = write(requests_, frame.data() + *sent, frame.size() - *sent);
  if (wrote > 0) *sent += static_cast<size_t>(wrote);
  if (wrote < 0 && errno == EPIPE) *sent = frame.size();  // nobody reads: the end of the replies will show why
}

bool WorkerProcess::Receive() {
  char buffer[1 << 16];
  for (;;) {
    const ssize_t got = read(replies_, buffer, sizeof(buffer));
    if (got > 0) received_.append(buffer, static_cast<size_t>(got));
    if (got == 0) return false;
    if (got < 0 && errno == EINTR) continue;
    // The frame's length is checked after each piece, so that the judge's memory cannot be filled.
    return true;
  }
}

void WorkerProcess::TakePrinted() {
  char buffer[1 << 12];
  for (int pieces = 0; prints_ >= 0 && pieces < 64; ++pieces) {
    const ssize_t got = read(prints_, buffer, sizeof(buffer));
    if (got == 0) Close(&prints_);
    if (got <= 0) return;
    printed_.append(buffer, std::min(static_cast<size_t>(got), kMaxPrinted - printed_.size()));
  }
}

const std::string& WorkerProcess::Printed() {
  TakePrinted();
  return printed_;
}

bool WorkerProcess::HasEnded(int* status) {
  waited_for_ = waited_for_ || waitpid(pid_, status, WNOHANG) == pid_;
  return waited_for_;
}

std::string WorkerProcess::HowEnded(const std::string& what) {
  int status = 0;
  const auto until = Clock::now() + kGrace;
  while (!HasEnded(&status) && Clock::now() < until) std::this_thread::sleep_for(2ms);
  TakePrinted();
  if (!waited_for_) return "EXIT: it closed its side without a reply in " + what;
  kill(-pid_, SIGKILL);  // what it has left in its group
  return InWords(status, what);
}

}  // namespace ch5::homework
