#include "ch5_homework/judge/compiled_products.h"

#ifdef CH5_COMPILED_PRODUCTS
// Eigen's functions for another destination, a Map, do what is announced for a matrix.
#define CH5_COMPILE_ONE(L, R, function)                 \
  CH5_PRODUCT(L, R, function) {                         \
    Map<MatrixXd> map(to.data(), to.rows(), to.cols()); \
    function(map, lhs, rhs);                            \
  }                                                     \
  static_assert(true)
#define CH5_COMPILE(L, R)                               \
  CH5_COMPILE_ONE(L, R, evalTo);                        \
  CH5_COMPILE_ONE(L, R, addTo);                         \
  CH5_COMPILE_ONE(L, R, subTo);                         \
  CH5_SCALED_PRODUCT(L, R) {                            \
    Map<MatrixXd> map(to.data(), to.rows(), to.cols()); \
    scaleAndAddTo(map, lhs, rhs, factor);               \
  }                                                     \
  static_assert(true)
#define CH5_COMPILE_VECTOR(L)                \
  CH5_SCALED_PRODUCT_WITH_VECTOR(L) {        \
    Map<VectorXd> map(to.data(), to.size()); \
    scaleAndAddTo(map, lhs, rhs, factor);    \
  }                                          \
  static_assert(true)

namespace Eigen::internal {
CH5_COMPILED_PRODUCTS(CH5_COMPILE, CH5_COMPILE_VECTOR, CH5_COMPILE_ONE);
}  // namespace Eigen::internal

void ch5::compiled::Invert(const Eigen::MatrixXd& matrix, Eigen::MatrixXd* inverse) {
  *inverse = matrix.partialPivLu().inverse();
}
#endif
