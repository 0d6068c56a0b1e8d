#pragma once
/// Numbers for the kernels, which load whole registers.

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "ch5_backend/math/large_pages.h"

namespace ch5 {

/// Leaves a vector's new numbers unset where no value is given: memory is then first touched by the thread that fills it.
template <typename T>
struct UnsetAllocator {
  using value_type = T;
  UnsetAllocator() = default;
  template <typename U>
  UnsetAllocator(const UnsetAllocator<U>&) {}  // NOLINT(google-explicit-constructor): as allocators are asked to
  T* allocate(size_t count) { return static_cast<T*>(AllocateArray(count * sizeof(T))); }
  void deallocate(T* numbers, size_t /*count*/) { FreeArray(numbers); }
  friend bool operator==(const UnsetAllocator&, const UnsetAllocator&) { return true; }
  friend bool operator!=(const UnsetAllocator&, const UnsetAllocator&) { return false; }
  template <typename U>
  void construct(U* number) {
#ifdef EIGEN_INITIALIZE_MATRICES_BY_NAN
    *number = std::numeric_limits<U>::quiet_NaN();
#else
    static_cast<void>(number);
#endif
  }
  template <typename U, typename... Args>
  void construct(U* number, Args&&... args) {
    ::new (static_cast<void*>(number)) U(std::forward<Args>(args)...);
  }
};

/// Numbers that begin at a multiple of 64 bytes; `resize` leaves new ones unset.
using AlignedVector = std::vector<double, UnsetAllocator<double>>;

/// As `assign(count, 0.0)`, which asks the allocator for each number, and cannot set a register's width of them at once.
inline void SetZeros(size_t count, AlignedVector* numbers) {
  numbers->clear();
  numbers->resize(count);
  std::fill(numbers->begin(), numbers->end(), 0.0);
}

}  // namespace ch5
