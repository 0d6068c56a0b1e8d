#include "ch5_backend/math/lists.h"

#include <gtest/gtest.h>

#include <numeric>
#include <string>

#include "ch5_backend/math/key_numbers.h"

namespace ch5 {
namespace {

TEST(Lists, HoldEmptyOnesToo) {
  const Lists lists{{3, 4}, {}, {5}};
  ASSERT_EQ(lists.size(), 3);
  EXPECT_EQ(std::vector<int>(lists[0].begin(), lists[0].end()), (std::vector<int>{3, 4}));
  EXPECT_EQ(lists[1].size(), 0);
  EXPECT_EQ(*lists[2].begin(), 5);
  EXPECT_EQ(Lists().size(), 0);
}

TEST(Lists, OfNumbersByAKey) {
  EXPECT_EQ(ListByKey(6, 4, [](int k) { return k * k % 3; }), (Lists{{0, 3}, {1, 2, 4, 5}, {}, {}}));
  EXPECT_EQ(ListByKey(0, 2, [](int) { return 0; }), (Lists{{}, {}}));
}

TEST(Lists, KeepTheOrderOfWhatIsAdded) {
  const Lists neighbors = MakeLists(4, [](const auto& add) {
    for (const auto& [a, b] : {std::pair(3, 0), std::pair(0, 1), std::pair(3, 1)}) add(a, b), add(b, a);
  });
  EXPECT_EQ(neighbors, (Lists{{3, 1}, {0, 3}, {}, {0, 1}}));
}

TEST(KeySort, KeepsTheOrderOfEqualOnesAndServesAgain) {
  KeySort sort;
  for (const int keys : {5, 2, 7}) {
    Array<int> items(40);
    std::iota(items.begin(), items.end(), 0);
    const Array<int> begins = sort(items.begin() + 3, items.end(), keys, [&](int k) { return k * k % keys; });
    ASSERT_EQ(begins.size(), static_cast<size_t>(keys) + 1);
    EXPECT_EQ(begins.back(), 37);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(items[k], k) << "not asked for";
    for (int key = 0; key < keys; ++key) {
      for (int k = 3 + begins[key]; k < 3 + begins[key + 1]; ++k) {
        EXPECT_EQ(items[k] * items[k] % keys, key);
        EXPECT_TRUE(k == 3 + begins[key] || items[k - 1] < items[k]);
      }
    }
  }
}

TEST(KeyNumbers, CountFromZeroAndBeginAnewAfterClear) {
  KeyNumbers<std::string> numbers;
  for (int round = 0; round < 2; ++round) {
    for (const int first : {0, 0, 300}) {  // the second time they are known
      for (int k = first; k < first + 300; ++k) EXPECT_EQ(numbers.Of(std::to_string(k)), k);
    }
    EXPECT_EQ(numbers.Keys()[42], "42");
    numbers.Clear();
    EXPECT_TRUE(numbers.Keys().empty());
    EXPECT_EQ(numbers.Of("7"), 0);
    numbers.Clear();
  }
}

}  // namespace
}  // namespace ch5
