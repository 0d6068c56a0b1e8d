#pragma once
/// Products of dynamic matrices, and of a covariance's size, compiled once. Each kind of product costs a file that is compiled
/// without optimization (the tests, a student's file) half a second: some hundred of Eigen's functions. Announced here as specializations,
/// they are taken from compiled_products.cc, where Eigen's own templates do the work; a factor that is an expression is
/// evaluated first. Sizes are still asserted where the product is written.

#include <Eigen/Dense>
#include <type_traits>

#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)  // the names are Eigen 3.4's
// NOLINTBEGIN(readability-identifier-naming): Eigen's names
namespace ch5::compiled {
using Jacobian = Eigen::Map<const Eigen::MatrixXd>;  // as Edge::Jacobian returns it
using Mat99 = Eigen::Matrix<double, 9, 9>;           // A P Aᵀ + B Q Bᵀ of stage 8c
using Mat96 = Eigen::Matrix<double, 9, 6>;
using Mat69 = Eigen::Matrix<double, 6, 9>;
template <typename L, typename R, int Kind>
using ProductOf = Eigen::internal::generic_product_impl<L, R, Eigen::DenseShape, Eigen::DenseShape, Kind>;
template <typename L, typename R>
using OfMatrices = ProductOf<L, R, Eigen::GemmProduct>;
template <typename L, typename R>
using To = Eigen::Matrix<typename L::Scalar, L::RowsAtCompileTime, R::ColsAtCompileTime>;
template <typename L>
using OfVector = ProductOf<L, Eigen::VectorXd, Eigen::GemvProduct>;

/// A product of expressions: both are evaluated first, so that only a few kinds of matrices are multiplied; and so is the
/// product, which Eigen wants in rows where the right factor is transposed.
template <typename L, typename R, int Kind>
struct OfExpressions {
  using Scalar = typename L::Scalar;
  template <typename T>
  using Plain = std::conditional_t<T::IsVectorAtCompileTime, typename T::PlainObject,
                                   Eigen::Matrix<Scalar, T::RowsAtCompileTime, T::ColsAtCompileTime>>;
  using OfPlain = ProductOf<Plain<L>, Plain<R>, Kind>;

  static To<L, R> Evaluated(const L& lhs, const R& rhs) {
    To<L, R> product(lhs.rows(), rhs.cols());
    OfPlain::evalTo(product, lhs, rhs);
    return product;
  }
  template <typename M>
  static void evalTo(M& to, const L& lhs, const R& rhs) {
    const To<L, R> product = Evaluated(lhs, rhs);
    to = product;  // copied: an evaluator keeps the address of these numbers
  }
  template <typename M>
  static void addTo(M& to, const L& lhs, const R& rhs) {
    to += Evaluated(lhs, rhs);
  }
  template <typename M>
  static void subTo(M& to, const L& lhs, const R& rhs) {
    to -= Evaluated(lhs, rhs);
  }
  template <typename M>
  static void scaleAndAddTo(M& to, const L& lhs, const R& rhs, const Scalar& factor) {
    to += factor * Evaluated(lhs, rhs);
  }
};

/// The inverse (n×n) of an n×n matrix, by LU with partial pivoting, as Eigen's own.
void Invert(const Eigen::MatrixXd& matrix, Eigen::MatrixXd* inverse);
}  // namespace ch5::compiled

// Which expressions: as the left factor any of these; as the right one, of a plain matrix, a product or an inverse.
namespace Eigen::internal {
#define CH5_EVALUATED_FIRST(kind)                                                            \
  template <typename A, typename B, int option, typename R>                                  \
  struct generic_product_impl<Product<A, B, option>, R, DenseShape, DenseShape, kind>        \
      : ch5::compiled::OfExpressions<Product<A, B, option>, R, kind> {};                     \
  template <typename F, typename A, typename B, typename R>                                  \
  struct generic_product_impl<CwiseBinaryOp<F, A, B>, R, DenseShape, DenseShape, kind>       \
      : ch5::compiled::OfExpressions<CwiseBinaryOp<F, A, B>, R, kind> {};                    \
  template <typename F, typename A, typename R>                                              \
  struct generic_product_impl<CwiseUnaryOp<F, A>, R, DenseShape, DenseShape, kind>           \
      : ch5::compiled::OfExpressions<CwiseUnaryOp<F, A>, R, kind> {};                        \
  template <typename A, typename R>                                                          \
  struct generic_product_impl<Inverse<A>, R, DenseShape, DenseShape, kind>                   \
      : ch5::compiled::OfExpressions<Inverse<A>, R, kind> {};                                \
  template <typename A, typename R>                                                          \
  struct generic_product_impl<Block<A, Dynamic, Dynamic>, R, DenseShape, DenseShape, kind>   \
      : ch5::compiled::OfExpressions<Block<A, Dynamic, Dynamic>, R, kind> {};                \
  template <typename A, typename B, int option>                                              \
  struct generic_product_impl<MatrixXd, Product<A, B, option>, DenseShape, DenseShape, kind> \
      : ch5::compiled::OfExpressions<MatrixXd, Product<A, B, option>, kind> {};              \
  template <typename A>                                                                      \
  struct generic_product_impl<MatrixXd, Inverse<A>, DenseShape, DenseShape, kind>            \
      : ch5::compiled::OfExpressions<MatrixXd, Inverse<A>, kind> {}
CH5_EVALUATED_FIRST(GemmProduct);
CH5_EVALUATED_FIRST(GemvProduct);

template <typename M>
struct compute_inverse<M, MatrixXd, Dynamic> {
  static void run(const M& matrix, MatrixXd& inverse) { ch5::compiled::Invert(matrix, &inverse); }
};
}  // namespace Eigen::internal

// Each is one(L, R) for the products L·R of two matrices, each_vector(L) for those with a vector, and one(L, R, evalTo) for
// those of fixed sizes.
#define CH5_COMPILED_PRODUCTS(each, each_vector, each_fixed)      \
  each_fixed(ch5::compiled::Mat99, ch5::compiled::Mat99, evalTo); \
  each_fixed(ch5::compiled::Mat96, ch5::compiled::Mat69, evalTo); \
  each(MatrixXd, MatrixXd);                                       \
  each(MatrixXd, Transpose<MatrixXd>);                            \
  each(MatrixXd, Transpose<const MatrixXd>);                      \
  each(MatrixXd, ch5::compiled::Jacobian);                        \
  each(Transpose<MatrixXd>, MatrixXd);                            \
  each(Transpose<const MatrixXd>, MatrixXd);                      \
  each(Transpose<ch5::compiled::Jacobian>, MatrixXd);             \
  each_vector(MatrixXd);                                          \
  each_vector(Transpose<MatrixXd>);                               \
  each_vector(Transpose<const MatrixXd>);                         \
  each_vector(Transpose<ch5::compiled::Jacobian>)
// The heads of what is specialized.
#define CH5_PRODUCT(L, R, function) \
  template <>                       \
  template <>                       \
  void ch5::compiled::OfMatrices<L, R>::function(ch5::compiled::To<L, R>& to, const L& lhs, const R& rhs)
#define CH5_SCALED_PRODUCT(L, R)                                                                               \
  template <>                                                                                                  \
  template <>                                                                                                  \
  void ch5::compiled::OfMatrices<L, R>::scaleAndAddTo(ch5::compiled::To<L, R>& to, const L& lhs, const R& rhs, \
                                                      const double& factor)
#define CH5_SCALED_PRODUCT_WITH_VECTOR(L)                                                         \
  template <>                                                                                     \
  template <>                                                                                     \
  void ch5::compiled::OfVector<L>::scaleAndAddTo(VectorXd& to, const L& lhs, const VectorXd& rhs, \
                                                 const double& factor)
#define CH5_ANNOUNCE(L, R)   \
  CH5_PRODUCT(L, R, evalTo); \
  CH5_PRODUCT(L, R, addTo);  \
  CH5_PRODUCT(L, R, subTo);  \
  CH5_SCALED_PRODUCT(L, R)

namespace Eigen::internal {
CH5_COMPILED_PRODUCTS(CH5_ANNOUNCE, CH5_SCALED_PRODUCT_WITH_VECTOR, CH5_PRODUCT);
}  // namespace Eigen::internal
// NOLINTEND(readability-identifier-naming)
#endif
