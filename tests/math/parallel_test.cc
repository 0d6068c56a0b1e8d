#include "ch5_backend/math/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

TEST(ThreadPool, RunsEachTaskOnce) {
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.Threads(), threads);
    for (int round = 0; round < 200; ++round) {  // the same threads again and again
      std::vector<std::atomic<int>> calls(static_cast<size_t>(round));
      pool.Run(round, [&](int i) { ++calls[i]; });
      for (const auto& count : calls) EXPECT_EQ(count, 1);
    }
  }
}

TEST(ThreadPool, HandsOnAnExceptionAndLivesOn) {
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    const auto throws = [](int i) {
      if (i == 5) throw std::runtime_error("task 5");
    };
    EXPECT_THROW(pool.Run(10, throws), std::runtime_error);
    std::atomic<int> sum{0};
    pool.Run(10, [&](int i) { sum += i; });
    EXPECT_EQ(sum, 45);
  }
}

TEST(ThreadPool, SumsAreTheSameToTheBit) {
  Random random(1);
  std::vector<double> values(10001), parts;
  for (double& value : values) value = random.Normal() * std::exp(10.0 * random.Normal());
  const auto sum_with = [&](int threads) {
    ThreadPool pool(threads);
    return ParallelSum(&pool, static_cast<int>(values.size()), 64, &parts, [&](int begin, int end) {
      double sum = 0.0;
      for (int i = begin; i < end; ++i) sum += values[i];
      return sum;
    });
  };
  EXPECT_EQ(sum_with(1), sum_with(2));
  EXPECT_EQ(sum_with(1), sum_with(5));
}

}  // namespace
}  // namespace ch5
