#pragma once
/// Memory of arrays. A window's solver makes hundreds of short ones for each image: a thread keeps those that are given back,
/// for the next of their size. Long ones lie in large pages: fewer page faults when they are first written, fewer TLB misses
/// afterwards. A page fault costs a microsecond or, on a virtual machine, ten; a solve writes some megabytes for the first time.

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace ch5 {

/// Memory that begins at a multiple of 64 bytes; in large pages, if it fills one and the system has them: to clear a page that
/// stays half empty costs more than it saves.
/// @throws std::bad_alloc
void* AllocateArray(size_t bytes);
/// @param bytes  as they were asked for; by this thread or another
void FreeArray(void* memory, size_t bytes);

/// An allocator of this memory.
template <typename T>
struct ArrayAllocator {
  using value_type = T;
  ArrayAllocator() = default;
  template <typename U>
  ArrayAllocator(const ArrayAllocator<U>&) {}  // NOLINT(google-explicit-constructor): as allocators are asked to
  T* allocate(size_t count) { return static_cast<T*>(AllocateArray(count * sizeof(T))); }
  void deallocate(T* items, size_t count) { FreeArray(items, count * sizeof(T)); }
  friend bool operator==(const ArrayAllocator&, const ArrayAllocator&) { return true; }
  friend bool operator!=(const ArrayAllocator&, const ArrayAllocator&) { return false; }
};

/// A vector that comes and goes with a window.
template <typename T>
using Array = std::vector<T, ArrayAllocator<T>>;

/// As std::make_shared, for an object that comes and goes with a window.
template <typename T, typename... Args>
std::shared_ptr<T> MakeShared(Args&&... args) {
  return std::allocate_shared<T>(ArrayAllocator<T>(), std::forward<Args>(args)...);
}

}  // namespace ch5
