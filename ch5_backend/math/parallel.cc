#include "ch5_backend/math/parallel.h"

#include <chrono>

#include "ch5_backend/math/option_checks.h"

namespace ch5 {
namespace {

// A solver's loops follow each other within microseconds, less than it takes to wake a thread. So a thread that waits looks
// again and again for a while before it sleeps, if each has a processor of its own.
template <typename Condition>
void WaitFor(const Condition& is_met, bool sleep_at_once, std::mutex* mutex, std::condition_variable* changed) {
  constexpr std::chrono::microseconds kAwake(100);
  const auto start = std::chrono::steady_clock::now();
  while (!is_met()) {
    if (!sleep_at_once && std::chrono::steady_clock::now() < start + kAwake) continue;
    std::unique_lock<std::mutex> lock(*mutex);
    return changed->wait(lock, is_met);
  }
}

}  // namespace

ThreadPool::ThreadPool(int threads) {
  CheckOption("threads", threads, 1, kMostThreads);
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

void ThreadPool::RunOnAll(int tasks, Function function, const void* context) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    function_ = function;
    context_ = context;
    tasks_ = tasks;
    next_task_ = 0;
    busy_ = static_cast<int>(workers_.size());
    error_ = nullptr;
    ++generation_;
  }
  begin_.notify_all();
  TakeTasks();
  WaitFor([this] { return busy_ == 0; }, sleeps_at_once_, &mutex_, &end_);
  if (error_) std::rethrow_exception(error_);
}

void ThreadPool::Work() {
  long seen = 0;
  for (;;) {
    WaitFor([&] { return stop_ || generation_ != seen; }, sleeps_at_once_, &mutex_, &begin_);
    if (stop_) return;
    seen = generation_;
    TakeTasks();
    if (--busy_ > 0) continue;
    const std::lock_guard<std::mutex> lock(mutex_);
    end_.notify_one();
  }
}

void ThreadPool::TakeTasks() {
  for (int i = next_task_++; i < tasks_; i = next_task_++) {
    try {
      function_(context_, i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!error_) error_ = std::current_exception();
    }
  }
}

}  // namespace ch5
