#pragma once
/// A small pool of threads that is made once and used for every loop.
///
/// The caller divides a loop into tasks whose sizes do not depend on the number of threads; a task writes only what
/// belongs to it. Sums have one term per task, added in the order of the tasks. So every result is the same to the
/// bit with one thread and with many.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace ch5 {

class ThreadPool {
 public:
  static constexpr int kMostThreads = 1024;
  /// @param threads  the calling one included, 1 to kMostThreads
  /// @throws OptionError
  explicit ThreadPool(int threads = 1);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int Threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls task(i) once for each i in [0, tasks), in any order and on any thread; returns when all are done.
  /// The first exception that a task throws is thrown again here, after the others have ended. Not to be nested.
  template <typename Task>
  void Run(int tasks, const Task& task) {
    if (workers_.empty() || tasks < 2) {
      for (int i = 0; i < tasks; ++i) task(i);
      return;
    }
    RunOnAll(
        tasks, [](const void* context, int i) { (*static_cast<const Task*>(context))(i); }, &task);
  }

 private:
  using Function = void (*)(const void* context, int task);  // a std::function would allocate

  void RunOnAll(int tasks, Function function, const void* context);
  void Work();
  void TakeTasks();
  template <typename Condition>
  void WaitFor(const Condition& is_met, int microseconds, std::condition_variable* changed);

  std::vector<std::thread> workers_;
  bool sleeps_at_once_ = false;  // a thread that waits
  std::mutex mutex_;
  std::condition_variable begin_, end_;
  // The next task of a loop, and the number of the loop above its 32 bits. Who takes a task counts it up, and fails if
  // what he has read of the loop is that of another one.
  std::atomic<uint64_t> ticket_{0};
  std::atomic<Function> function_{nullptr};
  std::atomic<const void*> context_{nullptr};
  std::atomic<uint32_t> tasks_{0};
  std::atomic<uint32_t> done_{0};  // tasks
  std::atomic<bool> stop_{false};
  std::exception_ptr error_;
};

/// Number of chunks of `size` items that cover `count` items.
inline int NumChunks(int count, int size) { return (count + size - 1) / size; }

/// Calls range(begin, end) for consecutive chunks of `size` items that cover [0, count).
/// @param pool  null: the calling thread alone
template <typename Range>
void ParallelFor(ThreadPool* pool, int count, int size, const Range& range) {
  const auto chunk = [&](int i) { range(i * size, i * size + size < count ? i * size + size : count); };
  const int chunks = NumChunks(count, size);
  if (pool) return pool->Run(chunks, chunk);
  for (int i = 0; i < chunks; ++i) chunk(i);
}

/// Σ range(begin, end) over the same chunks, added in order. `parts` keeps its memory between calls.
template <typename Parts, typename Range>
double ParallelSum(ThreadPool* pool, int count, int size, Parts* parts, const Range& range) {
  parts->assign(static_cast<size_t>(NumChunks(count, size)), 0.0);
  ParallelFor(pool, count, size, [&](int begin, int end) { (*parts)[begin / size] = range(begin, end); });
  double sum = 0.0;
  for (const double part : *parts) sum += part;
  return sum;
}

}  // namespace ch5
