#pragma once
/// Products of dynamic matrices, compiled once. Each kind of product costs a file that is compiled without optimisation
/// (the tests, a student's file) half a second: some hundred of Eigen's functions. Announced here as specialisations,
/// they are taken from compiled_products.cc, where Eigen's own templates do the work. Sizes are still asserted where
/// the product is written.

#include <Eigen/Dense>

#if EIGEN_VERSION_AT_LEAST(3, 4, 0) && !EIGEN_VERSION_AT_LEAST(3, 4, 90)  // the names are Eigen 3.4's
namespace ch5::compiled {
template <typename L>
using Times = Eigen::Product<L, Eigen::MatrixXd, Eigen::DefaultProduct>;  // L·A, itself a factor
using TimesDiagonal =
    Eigen::Product<Eigen::MatrixXd, Eigen::DiagonalWrapper<const Eigen::VectorXd>, Eigen::LazyProduct>;
using Jacobian = Eigen::Map<const Eigen::MatrixXd>;  // as Edge::Jacobian returns it
template <typename L, typename R>
using OfMatrices =
    Eigen::internal::generic_product_impl<L, R, Eigen::DenseShape, Eigen::DenseShape, Eigen::GemmProduct>;
template <typename L>
using OfVector =
    Eigen::internal::generic_product_impl<L, Eigen::VectorXd, Eigen::DenseShape, Eigen::DenseShape, Eigen::GemvProduct>;
}  // namespace ch5::compiled

// Each is one(L, R) for the products L·R of two matrices, each_vector(L) for those with a vector.
#define CH5_COMPILED_PRODUCTS(each, each_vector)                                           \
  each(MatrixXd, MatrixXd);                                                                \
  each(MatrixXd, Transpose<MatrixXd>);                                                     \
  each(MatrixXd, Transpose<const MatrixXd>);                                               \
  each(MatrixXd, ch5::compiled::Jacobian);                                                 \
  each(Transpose<MatrixXd>, MatrixXd);                                                     \
  each(Transpose<const MatrixXd>, MatrixXd);                                               \
  each(Transpose<ch5::compiled::Jacobian>, MatrixXd);                                      \
  each(ch5::compiled::TimesDiagonal, Transpose<const MatrixXd>);                           \
  each(ch5::compiled::Times<MatrixXd>, MatrixXd);                                          \
  each(ch5::compiled::Times<MatrixXd>, Transpose<MatrixXd>);                               \
  each(ch5::compiled::Times<MatrixXd>, Transpose<const MatrixXd>);                         \
  each(ch5::compiled::Times<Transpose<MatrixXd>>, MatrixXd);                               \
  each(ch5::compiled::Times<Transpose<const MatrixXd>>, MatrixXd);                         \
  each(ch5::compiled::Times<Transpose<const MatrixXd>>, ch5::compiled::Jacobian);          \
  each(ch5::compiled::Times<Transpose<ch5::compiled::Jacobian>>, ch5::compiled::Jacobian); \
  each_vector(MatrixXd);                                                                   \
  each_vector(Transpose<MatrixXd>);                                                        \
  each_vector(Transpose<const MatrixXd>);                                                  \
  each_vector(ch5::compiled::Times<MatrixXd>);                                             \
  each_vector(ch5::compiled::Times<Transpose<const MatrixXd>>)
#define CH5_ANNOUNCE(L, R)                                                                \
  template <>                                                                             \
  template <>                                                                             \
  void ch5::compiled::OfMatrices<L, R>::evalTo(MatrixXd& to, const L& lhs, const R& rhs); \
  template <>                                                                             \
  template <>                                                                             \
  void ch5::compiled::OfMatrices<L, R>::addTo(MatrixXd& to, const L& lhs, const R& rhs);  \
  template <>                                                                             \
  template <>                                                                             \
  void ch5::compiled::OfMatrices<L, R>::subTo(MatrixXd& to, const L& lhs, const R& rhs);  \
  template <>                                                                             \
  template <>                                                                             \
  void ch5::compiled::OfMatrices<L, R>::scaleAndAddTo(MatrixXd& to, const L& lhs, const R& rhs, const double& factor)
#define CH5_ANNOUNCE_VECTOR(L)                                                                    \
  template <>                                                                                     \
  template <>                                                                                     \
  void ch5::compiled::OfVector<L>::scaleAndAddTo(VectorXd& to, const L& lhs, const VectorXd& rhs, \
                                                 const double& factor)

namespace Eigen::internal {
CH5_COMPILED_PRODUCTS(CH5_ANNOUNCE, CH5_ANNOUNCE_VECTOR);
template <>
void compute_inverse<MatrixXd, MatrixXd, Dynamic>::run(const MatrixXd& matrix, MatrixXd& inverse);
}  // namespace Eigen::internal
#endif
