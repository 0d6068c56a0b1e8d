#include "ch5_backend/math/array_memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <thread>

namespace ch5 {
namespace {

TEST(ArrayMemory, BeginsAtWholeLinesAndHoldsWhatWasAskedFor) {
  for (size_t bytes : {0, 1, 64, 65, 1000, 1 << 16, (1 << 18) + 1, 5 << 20}) {
    for (int times = 0; times < 3; ++times) {
      void* memory = AllocateArray(bytes);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(memory) % 64, 0u);
      std::memset(memory, 0xff, bytes);
      FreeArray(memory, bytes);
    }
  }
}

// A vector's numbers are zero, whatever the memory held before.
TEST(ArrayMemory, ALaterVectorKnowsNothingOfTheFormer) {
  for (int times = 0; times < 100; ++times) {
    Array<int> numbers(200);
    for (int& number : numbers) EXPECT_EQ(std::exchange(number, 7), 0);
  }
}

TEST(ArrayMemory, ManyAtOnceAreApart) {
  for (int round = 0; round < 3; ++round) {
    Array<Array<int>> arrays;
    for (int k = 0; k < 500; ++k) arrays.emplace_back(static_cast<size_t>(1 + k % 90), k);
    for (int k = 0; k < 500; ++k) {
      for (const int number : arrays[static_cast<size_t>(k)]) ASSERT_EQ(number, k);
    }
  }
}

// Threads give back what others have taken, and end before their memory is used no more.
TEST(ArrayMemory, MovesBetweenThreads) {
  std::vector<Array<int>> arrays;
  for (int round = 0; round < 20; ++round) {
    std::thread([&] {
      for (int k = 0; k < 100; ++k) arrays.emplace_back(50, k);
    }).join();
    std::thread([&] { arrays.erase(arrays.begin(), arrays.begin() + 50); }).join();
    for (size_t k = 0; k < arrays.size(); ++k) ASSERT_EQ(arrays[k].back(), arrays[k].front());
  }
}

}  // namespace
}  // namespace ch5
