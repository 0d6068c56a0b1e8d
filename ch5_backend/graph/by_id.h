#pragma once
/// Vertices or edges in order of id. One that is removed leaves a hole, so that none behind it has to move; the holes are
/// closed when all are asked for: by whoever asks first, behind a lock, so that threads may read at once.

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

namespace ch5 {

template <typename T>
class ById {
 public:
  /// Without holes; the reference and its elements are good until the next change.
  const std::vector<std::shared_ptr<T>>& All() const {
    if (holes_.load(std::memory_order_acquire) == 0) return items_;
    const std::lock_guard lock(closing_);
    if (holes_.load(std::memory_order_relaxed) == 0) return items_;
    size_t kept = 0;
    for (size_t k = 0; k < items_.size(); ++k) {
      if (!items_[k]) continue;
      ids_[kept] = ids_[k];
      if (kept != k) items_[kept] = std::move(items_[k]);
      ++kept;
    }
    items_.resize(kept);
    ids_.resize(kept);
    holes_.store(0, std::memory_order_release);
    return items_;
  }

  /// The item with this id, or null.
  std::shared_ptr<T> Find(int id) const {
    return Read(id, [&](size_t k) { return ids_[k] == id ? items_[k] : nullptr; });
  }
  bool Contains(const T& item) const {
    return Read(item.Id(), [&](size_t k) { return items_[k].get() == &item; });
  }

  /// Its place in All(), in which it must be.
  size_t PositionOf(const T& item) const {
    All();
    return Position(item.Id());
  }

  /// The id must be free. Mostly it is the last.
  void Insert(std::shared_ptr<T> item, int id) {
    const size_t k = Position(id);
    if (k < ids_.size() && ids_[k] == id) {
      items_[k] = std::move(item);
      --holes_;
      return;
    }
    items_.insert(items_.begin() + static_cast<long>(k), std::move(item));
    ids_.insert(ids_.begin() + static_cast<long>(k), id);
  }

  /// There must be an item with this id.
  void Remove(int id) {
    items_[Position(id)] = nullptr;
    ++holes_;
  }

  /// Keeps its memory.
  void Clear() {
    items_.clear();
    ids_.clear();
    holes_ = 0;
  }
  void Swap(ById* other) noexcept {
    items_.swap(other->items_);
    ids_.swap(other->ids_);
    holes_ = other->holes_.exchange(holes_);
  }

 private:
  // What `read` says of the position of an id, if there is one. Somebody may be closing the holes.
  template <typename Function>
  auto Read(int id, const Function& read) const {
    std::unique_lock lock(closing_, std::defer_lock);
    if (holes_.load(std::memory_order_acquire) > 0) lock.lock();
    const size_t k = Position(id);
    return k < ids_.size() ? read(k) : decltype(read(k))();
  }

  // The first position whose id is not less. Ids ascend, so it is never behind the position `id`, and mostly there.
  size_t Position(int id) const {
    if (ids_.empty() || ids_.back() < id) return ids_.size();
    const auto last = ids_.begin() + std::clamp(id, 0, static_cast<int>(ids_.size()) - 1);
    return static_cast<size_t>((*last == id ? last : std::lower_bound(ids_.begin(), last, id)) - ids_.begin());
  }

  mutable std::vector<std::shared_ptr<T>> items_;
  mutable std::vector<int> ids_;  // of each position, that of a hole too
  mutable std::atomic<size_t> holes_ = 0;
  mutable std::mutex closing_;
};

}  // namespace ch5
