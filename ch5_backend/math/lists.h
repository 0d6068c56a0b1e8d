#pragma once
/// Many short lists of numbers, one behind the other in one array, as the columns of a sparse matrix: a vector of vectors would
/// ask for memory once for each.

#include <cstddef>
#include <initializer_list>
#include <vector>

#include "ch5_backend/math/array_memory.h"

namespace ch5 {

struct Lists {
  Array<int> items, begin;  ///< list k has items [begin[k], begin[k + 1])

  /// One list, valid until items changes.
  struct View {
    const int *first, *last;
    const int* begin() const { return first; }
    const int* end() const { return last; }
    int size() const { return static_cast<int>(last - first); }
  };

  Lists() : Lists(0) {}
  /// None yet, but room for so many.
  explicit Lists(size_t lists, size_t items_in_all = 0) {
    begin.reserve(lists + 1);
    begin.push_back(0);
    items.reserve(items_in_all);
  }
  Lists(const std::vector<std::vector<int>>& lists) : Lists(lists.size()) {  // NOLINT(google-explicit-constructor)
    for (const auto& list : lists) {
      items.insert(items.end(), list.begin(), list.end());
      End();
    }
  }
  Lists(std::initializer_list<std::vector<int>> lists) : Lists(std::vector<std::vector<int>>(lists)) {}

  int size() const { return static_cast<int>(begin.size()) - 1; }
  View operator[](int k) const {
    const int* from = begin.data() + k;
    return {items.data() + from[0], items.data() + from[1]};
  }
  /// What has been added to items since the last call is a list.
  void End() { begin.push_back(static_cast<int>(items.size())); }
  friend bool operator==(const Lists& a, const Lists& b) { return a.items == b.items && a.begin == b.begin; }
};

/// Each list of what `each` gives, in its order.
/// @param each  each(add) calls add(list, item), list < num_lists, for every item; it is called twice, to count and to place
template <typename Each>
Lists MakeLists(int num_lists, const Each& each) {
  Lists lists;
  const auto begin_of = [&](int list) -> int& { return lists.begin[static_cast<size_t>(list)]; };
  lists.begin.assign(static_cast<size_t>(num_lists) + 2, 0);
  each([&](int list, int /*item*/) { ++begin_of(list + 2); });
  for (int k = 2; k <= num_lists + 1; ++k) begin_of(k) += begin_of(k - 1);
  lists.items.resize(static_cast<size_t>(lists.begin.back()));
  each(
      [&](int list, int item) { lists.items[static_cast<size_t>(begin_of(list + 1)++)] = item; });  // list k ends there
  lists.begin.pop_back();
  return lists;
}

/// The numbers 0 … count − 1 by a key in [0, num_lists).
template <typename Key>
Lists ListByKey(int count, int num_lists, const Key& key) {
  return MakeLists(num_lists, [&](const auto& add) {
    for (int k = 0; k < count; ++k) add(key(k), k);
  });
}

/// Sorts items by a key in [0, num_keys), equal ones in their order. Its memory serves the next call.
class KeySort {
 public:
  /// @return where the items of each key begin, and where the last ones end, counted from `begin`; valid until the next call
  template <typename Key>
  const Array<int>& operator()(Array<int>::iterator begin, Array<int>::iterator end, int num_keys, const Key& key) {
    const auto begin_of = [&](int of) -> int& { return begins_[static_cast<size_t>(of)]; };
    begins_.assign(static_cast<size_t>(num_keys) + 2, 0);
    for (auto item = begin; item != end; ++item) ++begin_of(key(*item) + 2);
    for (int k = 2; k <= num_keys; ++k) begin_of(k) += begin_of(k - 1);
    items_.assign(begin, end);
    for (const int item : items_) begin[begin_of(key(item) + 1)++] = item;
    begins_.pop_back();
    return begins_;
  }

 private:
  Array<int> begins_, items_;
};

}  // namespace ch5
