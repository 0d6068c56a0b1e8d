#pragma once
/// Vertices or edges in order of id. One that is removed leaves a hole, so that none behind it has to move; the holes are
/// closed when all are asked for.

#include <algorithm>
#include <memory>
#include <vector>

namespace ch5 {

template <typename T>
class ById {
 public:
  /// Without holes; the reference and its elements are good until the next change.
  const std::vector<std::shared_ptr<T>>& All() const {
    if (holes_ == 0) return items_;
    size_t kept = 0;
    for (size_t k = 0; k < items_.size(); ++k) {
      if (!items_[k]) continue;
      ids_[kept] = ids_[k];
      if (kept != k) items_[kept] = std::move(items_[k]);
      ++kept;
    }
    items_.resize(kept);
    ids_.resize(kept);
    holes_ = 0;
    return items_;
  }

  /// The item with this id, or null.
  const std::shared_ptr<T>& Find(int id) const {
    static const std::shared_ptr<T> none;
    const size_t k = Position(id);
    return k < ids_.size() && ids_[k] == id ? items_[k] : none;
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

  void Swap(ById* other) noexcept {
    items_.swap(other->items_);
    ids_.swap(other->ids_);
    std::swap(holes_, other->holes_);
  }

 private:
  // The first position whose id is not less. Ids ascend, so it is never behind the position `id`, and mostly there.
  size_t Position(int id) const {
    if (ids_.empty() || ids_.back() < id) return ids_.size();
    const auto last = ids_.begin() + std::clamp(id, 0, static_cast<int>(ids_.size()) - 1);
    return static_cast<size_t>((*last == id ? last : std::lower_bound(ids_.begin(), last, id)) - ids_.begin());
  }

  mutable std::vector<std::shared_ptr<T>> items_;
  mutable std::vector<int> ids_;  // of each position, that of a hole too
  mutable size_t holes_ = 0;
};

}  // namespace ch5
