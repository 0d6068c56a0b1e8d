#include "ch5_backend/math/large_pages.h"

#include <algorithm>
#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace ch5 {

void* AllocateArray(size_t bytes) {
  constexpr size_t kLine = 64, kLargePage = size_t{1} << 21;
  const bool is_large = bytes >= kLargePage;
  const size_t unit = is_large ? kLargePage : kLine, whole = (std::max(bytes, size_t{1}) + unit - 1) / unit * unit;
  void* memory = std::aligned_alloc(unit, whole);
  if (!memory) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (is_large) madvise(memory, whole, MADV_HUGEPAGE);
#endif
  return memory;
}

void FreeArray(void* memory) { std::free(memory); }

}  // namespace ch5
