#include "ch5_homework/judge/unset_memory.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(CH5_SANITIZED)  // sanitizers have a malloc of their own
#include <malloc.h>
#include <unistd.h>

extern "C" void* __libc_malloc(size_t size);
extern "C" void __libc_free(void* memory);

namespace {

constexpr size_t kMost = 64 << 20;  // bytes: of a size that is wrong, not all need be touched
constexpr size_t kKept = 256;       // given back blocks of memory that nobody gets yet
constexpr size_t kSmall = 1 << 16;  // bytes: larger blocks are not kept

std::atomic<void*> kept[kKept];
std::atomic<size_t> next{0};

// Its own marks would hide from the library that memory is given back twice.
void RequireOwned(const void* memory) {
  if (malloc_usable_size(const_cast<void*>(memory)) == 0 ||
      *static_cast<const uint64_t*>(memory) != ch5::homework::kFreed)
    return;
  for (const auto& one : kept) {
    if (one != memory) continue;
    static const char words[] = "Assertion `memory is given back once' failed.\n";
    if (write(2, words, sizeof words - 1) > 0) std::abort();
  }
}

void Fill(void* memory, uint64_t bits) {
  auto* words = static_cast<uint64_t*>(memory);
  for (size_t k = 0, n = std::min(malloc_usable_size(memory), kMost) / sizeof bits; k < n; ++k) words[k] = bits;
}

}  // namespace

// Eigen's matrices and operator new end here; calloc, which promises zeros, does not.
extern "C" void* malloc(size_t size) {
  void* memory = __libc_malloc(size);
  if (memory != nullptr) Fill(memory, ch5::homework::kFresh);
  return memory;
}

extern "C" void free(void* memory) {
  if (memory == nullptr) return;
  RequireOwned(memory);
  Fill(memory, ch5::homework::kFreed);
  if (malloc_usable_size(memory) <= kSmall) {  // what still refers to it must not meet the next one's numbers there
    memory = kept[next.fetch_add(1) % kKept].exchange(memory);
  }
  __libc_free(memory);
}
#endif
