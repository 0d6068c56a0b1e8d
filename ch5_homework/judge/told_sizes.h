#pragma once
/// What Eigen's assertions know of sizes, told before they end a student's program. Included before Eigen.
///
/// An assertion is a macro: in it the parameters of Eigen's own functions have their names, startRow of a block, aLhs of a sum.
/// Where a function has no such parameter, the name is that of a constant below, which has no size.

#include <cassert>
#include <cstdio>
#include <initializer_list>

#ifndef NDEBUG
namespace ch5::homework {

struct Unknown {
  constexpr operator long() const { return -1; }
};
struct Told {
  long rows, columns;
};
template <typename Matrix>
auto SizeOf(const Matrix& A, int) -> decltype(Told{A.rows(), A.cols()}) {
  return {A.rows(), A.cols()};
}
template <typename Other>
Told SizeOf(const Other&, long) {
  return {-1, -1};
}

[[noreturn]] inline void FailWith(const char* assertion, const char* file, unsigned line, const char* function,
                                  std::initializer_list<Told> numbers) {
  std::fputs("\nSIZES", stderr);
  for (const Told& two : numbers) std::fprintf(stderr, " %ld %ld", two.rows, two.columns);
  std::fputs("\n", stderr);
  __assert_fail(assertion, file, line, function);
}

}  // namespace ch5::homework

// NOLINTBEGIN(readability-identifier-naming): Eigen's names
namespace Eigen {
constexpr ch5::homework::Unknown startRow, startCol, blockRows, blockCols, xpr, aLhs, aRhs, dst, src;
}
// NOLINTEND(readability-identifier-naming)

#define CH5_SIZE(matrix) ch5::homework::SizeOf(matrix, 0)
#define eigen_assert(x)                                                       \
  ((x) ? void()                                                               \
       : ch5::homework::FailWith(#x, __FILE__, __LINE__, __PRETTY_FUNCTION__, \
                                 {{startRow, startCol},                       \
                                  {blockRows, blockCols},                     \
                                  CH5_SIZE(xpr),                              \
                                  CH5_SIZE(aLhs),                             \
                                  CH5_SIZE(aRhs),                             \
                                  CH5_SIZE(dst),                              \
                                  CH5_SIZE(src)}))
#endif
