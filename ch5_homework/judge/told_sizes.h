#pragma once
/// What Eigen's assertions know of sizes, told before they end a student's program. Included before Eigen.
///
/// An assertion is a macro: in it the parameters and members of Eigen's own have their names, startRow of a block, m_lhs of a
/// sum or a product. Where there is no such name, it is that of a constant below, which has no size.

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
constexpr ch5::homework::Unknown startRow, startCol, blockRows, blockCols, xpr, m_lhs, m_rhs, dst, src;
}
// NOLINTEND(readability-identifier-naming)

#define CH5_SIZE(matrix) ch5::homework::SizeOf(matrix, 0)
#define eigen_assert(x)                                                       \
  ((x) ? void()                                                               \
       : ch5::homework::FailWith(#x, __FILE__, __LINE__, __PRETTY_FUNCTION__, \
                                 {{startRow, startCol},                       \
                                  {blockRows, blockCols},                     \
                                  CH5_SIZE(xpr),                              \
                                  CH5_SIZE(m_lhs),                            \
                                  CH5_SIZE(m_rhs),                            \
                                  CH5_SIZE(dst),                              \
                                  CH5_SIZE(src)}))

#include <Eigen/Core>

namespace Eigen::internal {
// Eigen resizes what is assigned to, and a block's resize(…), which refuses, knows neither size.
template <typename X, int m, int n, bool inner, typename Src, typename A, typename B>
void resize_if_allowed(Block<X, m, n, inner>& dst, const Src& src, const assign_op<A, B>&) {
  eigen_assert(dst.rows() == src.rows() && dst.cols() == src.cols());
}
template <typename X, int n, typename Src, typename A, typename B>
void resize_if_allowed(VectorBlock<X, n>& dst, const Src& src, const assign_op<A, B>&) {
  eigen_assert(dst.rows() == src.rows() && dst.cols() == src.cols());
}
}  // namespace Eigen::internal
#endif
