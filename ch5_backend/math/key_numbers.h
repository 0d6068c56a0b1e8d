#pragma once
/// Numbers keys in the order in which they come: a hash table with open addressing, whose memory serves again after Clear.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace ch5 {

template <typename Key, typename Hash = std::hash<Key>>
class KeyNumbers {
 public:
  void Clear() {
    keys_.clear();
    places_.assign(places_.size(), kEmpty);
  }
  /// The key's number, a new one where it has none.
  int Of(const Key& key) {
    if (2 * keys_.size() >= places_.size()) Grow();
    int& place = PlaceOf(key);
    if (place != kEmpty) return place;
    place = static_cast<int>(keys_.size());
    keys_.push_back(key);
    return place;
  }
  /// By number.
  const std::vector<Key>& Keys() const { return keys_; }

 private:
  static constexpr int kEmpty = -1;

  // Where the key is, or else belongs. Addresses are multiples of 8 or more: their upper bits tell them apart.
  int& PlaceOf(const Key& key) {
    const size_t last = places_.size() - 1;
    size_t place = static_cast<size_t>((Hash()(key) * UINT64_C(0x9e3779b97f4a7c15)) >> 32) & last;
    while (places_[place] != kEmpty && !(keys_[static_cast<size_t>(places_[place])] == key)) place = (place + 1) & last;
    return places_[place];
  }
  void Grow() {
    constexpr size_t kLeast = 64;
    places_.assign(places_.empty() ? kLeast : 2 * places_.size(), kEmpty);
    for (size_t k = 0; k < keys_.size(); ++k) PlaceOf(keys_[k]) = static_cast<int>(k);
  }

  std::vector<Key> keys_;
  std::vector<int> places_;  // 2^n of them, at most half of them taken
};

}  // namespace ch5
