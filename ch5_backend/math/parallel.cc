#include "ch5_backend/math/parallel.h"

#include <chrono>

#include "ch5_backend/math/option_checks.h"

namespace ch5 {
namespace {

constexpr uint64_t kLoop = uint64_t{1} << 32, kNoTask = kLoop - 1;

uint32_t TaskOf(uint64_t ticket) { return static_cast<uint32_t>(ticket % kLoop); }

}  // namespace

ThreadPool::ThreadPool(int threads) {
  CheckOption("threads", threads, 1, kMostThreads);
  if (threads == 1) return;  // without asking the system how many processors there are, which takes microseconds
  sleeps_at_once_ = threads > static_cast<int>(std::thread::hardware_concurrency());
  for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { Work(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  begin_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

// A solver's loops follow each other within microseconds, less than it takes to wake a thread. So a thread that waits looks
// again and again for a while before it sleeps, if each has a processor of its own.
template <typename Condition>
void ThreadPool::WaitFor(const Condition& is_met, int microseconds, std::condition_variable* changed) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::microseconds(sleeps_at_once_ ? 0 : microseconds);
  while (!is_met()) {
    if (Clock::now() < end) continue;
    std::unique_lock<std::mutex> lock(mutex_);
    changed->wait(lock, is_met);
  }
}

// A worker that comes late, as the processor is busy with something else, finds no task, and no thread waits for it.
void ThreadPool::RunOnAll(int tasks, Function function, const void* context) {
  const uint64_t loop = (ticket_ / kLoop + 1) * kLoop;
  ticket_ = loop + kNoTask;  // while the loop is described
  function_ = function;
  context_ = context;
  tasks_ = static_cast<uint32_t>(tasks);
  done_ = 0;
  error_ = nullptr;
  ticket_ = loop;
  { const std::lock_guard<std::mutex> lock(mutex_); }  // a worker that has found no loop sleeps by now
  begin_.notify_all();
  TakeTasks();
  WaitFor([this] { return done_ == tasks_; }, 20, &end_);  // a worker may need this processor to end its task
  if (error_) std::rethrow_exception(error_);
}

void ThreadPool::Work() {
  while (!stop_) {
    TakeTasks();
    WaitFor([this] { return stop_ || TaskOf(ticket_) < tasks_; }, 100, &begin_);
  }
}

void ThreadPool::TakeTasks() {
  for (;;) {
    uint64_t ticket = ticket_;
    const Function function = function_;
    const void* context = context_;
    const uint32_t tasks = tasks_, task = TaskOf(ticket);
    if (task >= tasks) return;
    if (!ticket_.compare_exchange_strong(ticket, ticket + 1)) continue;
    try {
      function(context, static_cast<int>(task));
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!error_) error_ = std::current_exception();
    }
    if (++done_ < tasks) continue;
    const std::lock_guard<std::mutex> lock(mutex_);
    end_.notify_one();
  }
}

}  // namespace ch5
