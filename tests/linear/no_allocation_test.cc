#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "ch5_backend/linear/sparse_cholesky.h"
#include "tests/linear/block_matrices.h"

namespace {
std::atomic<long> allocations{0};
}

// Every allocation of this program is counted. Not inlined: the compiler would see new meet free.
[[gnu::noinline]] void* operator new(size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }

namespace ch5::test {
namespace {

TEST(SparseCholesky, FactorizesOftenWithoutTakingMemory) {
  const SymmetricBlockMatrix A = MakeMatrix(std::vector<int>(400, 6), Grid(20), 12);
  const VecX b = RandomVector(A.Size(), 23), min_pivot = VecX::Zero(A.Size());
  for (const int threads : {1, 2}) {
    SparseCholesky cholesky(threads);
    cholesky.Analyze(A);
    VecX x(A.Size());
    const long before = allocations;
    for (int repeat = 0; repeat < 3; ++repeat) {
      ASSERT_TRUE(cholesky.Factorize(A, min_pivot));
      cholesky.Solve(b, &x);
    }
    EXPECT_EQ(allocations, before) << threads << " threads";
  }
}

}  // namespace
}  // namespace ch5::test
