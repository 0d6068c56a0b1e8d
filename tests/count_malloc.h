#pragma once
/// Counts calls of malloc, in which operator new and Eigen's matrices end too, where CH5_COUNTS_MALLOC is defined. For one file of
/// a program.

#include <atomic>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define CH5_COUNTS_MALLOC

namespace ch5::test {
inline std::atomic<bool> counting = false;
inline std::atomic<size_t> allocations = 0;
}  // namespace ch5::test

extern "C" void* __libc_malloc(size_t size);  // NOLINT(bugprone-reserved-identifier): glibc's name
extern "C" void* malloc(size_t size) {
  if (ch5::test::counting) ++ch5::test::allocations;
  return __libc_malloc(size);
}
#endif
