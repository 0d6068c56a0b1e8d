#pragma once
/// Products of dynamic matrices, compiled once. Each kind of product costs a file that is compiled without optimization (the tests, a
/// student's file) half a second: some hundred of Eigen's functions. Here all kinds end in one function; a factor that is an
/// expression is evaluated first. Sizes are still asserted where the product is written.

#include <Eigen/Dense>
#include <type_traits>

#include "ch5_homework/judge/in_memory.h"

#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)  // the names are Eigen 3.4's
// NOLINTBEGIN(readability-identifier-naming): Eigen's names
namespace ch5::compiled {

template <typename Number, typename M>
View<Number> ViewOf(M& A) {
  return {A.data(), A.rows(), A.cols(), A.rowStride(), A.colStride()};
}

/// The matrix itself if it is in memory, else its numbers.
template <typename T>
decltype(auto) InMemory(const T& x) {
  if constexpr ((Eigen::internal::traits<T>::Flags & Eigen::DirectAccessBit) != 0) {
    return (x);
  } else {
    return typename T::PlainObject(x);
  }
}

/// As Eigen's generic_product_impl.
template <typename L, typename R>
struct OfDoubles {
  template <typename M>
  static void evalTo(M& to, const L& lhs, const R& rhs) {
    Into(to, lhs, rhs, 1.0, false);
  }
  template <typename M>
  static void addTo(M& to, const L& lhs, const R& rhs) {
    Into(to, lhs, rhs, 1.0, true);
  }
  template <typename M>
  static void subTo(M& to, const L& lhs, const R& rhs) {
    Into(to, lhs, rhs, -1.0, true);
  }
  template <typename M>
  static void scaleAndAddTo(M& to, const L& lhs, const R& rhs, double factor) {
    Into(to, lhs, rhs, factor, true);
  }

 private:
  template <typename M>
  static void Into(M& to, const L& lhs, const R& rhs, double factor, bool adds) {
    const auto& A = InMemory(lhs);
    const auto& B = InMemory(rhs);
    Multiply(factor, ViewOf<const double>(A), ViewOf<const double>(B), adds, ViewOf<double>(to));
  }
};

/// As Eigen's of small matrices.
template <typename L, typename R>
struct OfOthers {
  template <typename M>
  static void evalTo(M& to, const L& lhs, const R& rhs) {
    to.noalias() = lhs.lazyProduct(rhs);
  }
  template <typename M>
  static void addTo(M& to, const L& lhs, const R& rhs) {
    to.noalias() += lhs.lazyProduct(rhs);
  }
  template <typename M>
  static void subTo(M& to, const L& lhs, const R& rhs) {
    to.noalias() -= lhs.lazyProduct(rhs);
  }
  template <typename M, typename Factor>
  static void scaleAndAddTo(M& to, const L& lhs, const R& rhs, const Factor& factor) {
    to.noalias() += factor * lhs.lazyProduct(rhs);
  }
};

template <typename L, typename R>
using Product =
    std::conditional_t<std::is_same_v<typename L::Scalar, double> && std::is_same_v<typename R::Scalar, double>,
                       OfDoubles<L, R>, OfOthers<L, R>>;
}  // namespace ch5::compiled

namespace Eigen::internal {
// By the left factor alone: one more list, of the right ones, would make two of these fit.
#define CH5_COMPILED(kind)                                                                                   \
  template <int m, int n, int option, int most_m, int most_n, typename R>                                    \
  struct generic_product_impl<Matrix<double, m, n, option, most_m, most_n>, R, DenseShape, DenseShape, kind> \
      : ch5::compiled::Product<Matrix<double, m, n, option, most_m, most_n>, R> {};                          \
  template <typename A, typename R>                                                                          \
  struct generic_product_impl<Transpose<A>, R, DenseShape, DenseShape, kind>                                 \
      : ch5::compiled::Product<Transpose<A>, R> {};                                                          \
  template <typename A, int option, typename Stride, typename R>                                             \
  struct generic_product_impl<Map<A, option, Stride>, R, DenseShape, DenseShape, kind>                       \
      : ch5::compiled::Product<Map<A, option, Stride>, R> {};                                                \
  template <typename A, int m, int n, bool inner, typename R>                                                \
  struct generic_product_impl<Block<A, m, n, inner>, R, DenseShape, DenseShape, kind>                        \
      : ch5::compiled::Product<Block<A, m, n, inner>, R> {};                                                 \
  template <typename A, typename B, int option, typename R>                                                  \
  struct generic_product_impl<Product<A, B, option>, R, DenseShape, DenseShape, kind>                        \
      : ch5::compiled::Product<Product<A, B, option>, R> {};                                                 \
  template <typename F, typename A, typename B, typename R>                                                  \
  struct generic_product_impl<CwiseBinaryOp<F, A, B>, R, DenseShape, DenseShape, kind>                       \
      : ch5::compiled::Product<CwiseBinaryOp<F, A, B>, R> {};                                                \
  template <typename F, typename A, typename R>                                                              \
  struct generic_product_impl<CwiseUnaryOp<F, A>, R, DenseShape, DenseShape, kind>                           \
      : ch5::compiled::Product<CwiseUnaryOp<F, A>, R> {};                                                    \
  template <typename A, typename R>                                                                          \
  struct generic_product_impl<Inverse<A>, R, DenseShape, DenseShape, kind> : ch5::compiled::Product<Inverse<A>, R> {}
CH5_COMPILED(GemmProduct);
CH5_COMPILED(GemvProduct);
#ifdef CH5_SMALL_PRODUCTS  // too: not of the tests, which compare the library with Eigen to the bit
CH5_COMPILED(CoeffBasedProductMode);
#endif

template <typename M>
struct compute_inverse<M, MatrixXd, Dynamic> {
  static void run(const M& matrix, MatrixXd& inverse) {
    MatrixXd A = matrix;
    inverse.resize(A.rows(), A.cols());
    ch5::compiled::Invert(ch5::compiled::ViewOf<double>(A), ch5::compiled::ViewOf<double>(inverse));
  }
};

// Four of math/precompiled.h, whose instances would take a first check 5 s: stand_ins.cc has them for checks, and for others the
// library. To be included before that header.
#ifndef CH5_NATIVE
template <>
void apply_block_householder_on_the_left(Block<MatrixXd>& A, const Block<MatrixXd>& V,
                                         const VectorBlock<const VectorXd>& h, bool last_first);
template <>
void apply_block_householder_on_the_left(Block<MatrixXd>& A, const Block<MatrixXd>& V,
                                         const Block<VectorXd, Dynamic, 1>& h, bool last_first);
template <>
void tridiagonalization_inplace(MatrixXd& A, VectorXd& diagonal, VectorXd& beside, VectorXd&, bool);
template <>
void partial_lu_inplace(MatrixXd& A, Transpositions<Dynamic>& pivots, int& transpositions);
#endif
}  // namespace Eigen::internal
// NOLINTEND(readability-identifier-naming)
#endif
