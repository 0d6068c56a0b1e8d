#include "tests/homework/poison.h"

#include <algorithm>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(CH5_SANITIZED)  // sanitizers have a malloc of their own
#include <malloc.h>

extern "C" void* __libc_malloc(size_t size);
extern "C" void __libc_free(void* memory);

namespace {

constexpr size_t kMost = 64 << 20;  // bytes: of a size that is wrong, not all need be touched

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
  Fill(memory, ch5::homework::kFreed);
  __libc_free(memory);
}
#endif
