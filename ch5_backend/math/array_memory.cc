#include "ch5_backend/math/array_memory.h"

#include <algorithm>
#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace ch5 {
namespace {

constexpr size_t kLine = 64, kLargePage = size_t{1} << 21;
constexpr size_t kKeptSizes = 13;       // 64 bytes, 128, …, 256 KB
constexpr size_t kKeptBytes = 1 << 20;  // at most, of each size

// A sanitizer sees each array come and go.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)  // GCC
constexpr bool kKeepsNone = true;
#elif defined(__has_feature)  // Clang
constexpr bool kKeepsNone =
    __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer);
#else
constexpr bool kKeepsNone = false;
#endif

// What a thread has been given back. Plain data: objects that live longer than this thread's others may still give back.
struct KeptBlocks {
  struct Block {
    Block* next;
  };
  Block* first[kKeptSizes];
  size_t count[kKeptSizes];
  bool is_over;  // the thread ends
};
thread_local KeptBlocks kept;

struct AtThreadsEnd {
  ~AtThreadsEnd() {
    kept.is_over = true;
    for (KeptBlocks::Block* block : kept.first) {
      while (block) std::free(std::exchange(block, block->next));
    }
  }
};

// k of the first size, 64 · 2^k, that holds so many bytes; kKeptSizes or more: none.
size_t SizeOf(size_t bytes) {
  size_t k = kKeepsNone ? kKeptSizes : 0;
  while (k < kKeptSizes && kLine << k < bytes) ++k;
  return k;
}

}  // namespace

void* AllocateArray(size_t bytes) {
  const size_t k = SizeOf(bytes);
  if (k < kKeptSizes && kept.first[k]) {
    --kept.count[k];
    return std::exchange(kept.first[k], kept.first[k]->next);
  }
  const bool is_large = bytes >= kLargePage;
  const size_t unit = is_large ? kLargePage : kLine, least = k < kKeptSizes ? kLine << k : bytes;
  const size_t whole = (least + unit - 1) / unit * unit;
  void* memory = std::aligned_alloc(unit, whole);
  if (!memory) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (is_large) madvise(memory, whole, MADV_HUGEPAGE);
#endif
  return memory;
}

void FreeArray(void* memory, size_t bytes) {
  thread_local const AtThreadsEnd at_end;
  const size_t k = SizeOf(bytes);
  if (k >= kKeptSizes || kept.is_over || (kept.count[k] + 1) * (kLine << k) > kKeptBytes) return std::free(memory);
  ++kept.count[k];
  kept.first[k] = new (memory) KeptBlocks::Block{kept.first[k]};
}

}  // namespace ch5
