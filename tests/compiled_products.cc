#include "tests/compiled_products.h"

#ifdef CH5_COMPILED_PRODUCTS
// Eigen's functions for another destination, a Map, do what is announced for a matrix.
#define CH5_COMPILE(L, R)                                                                       \
  template <>                                                                                   \
  template <>                                                                                   \
  void ch5::compiled::OfMatrices<L, R>::evalTo(MatrixXd& to, const L& lhs, const R& rhs) {      \
    Map<MatrixXd> map(to.data(), to.rows(), to.cols());                                         \
    evalTo(map, lhs, rhs);                                                                      \
  }                                                                                             \
  template <>                                                                                   \
  template <>                                                                                   \
  void ch5::compiled::OfMatrices<L, R>::addTo(MatrixXd& to, const L& lhs, const R& rhs) {       \
    Map<MatrixXd> map(to.data(), to.rows(), to.cols());                                         \
    addTo(map, lhs, rhs);                                                                       \
  }                                                                                             \
  template <>                                                                                   \
  template <>                                                                                   \
  void ch5::compiled::OfMatrices<L, R>::subTo(MatrixXd& to, const L& lhs, const R& rhs) {       \
    Map<MatrixXd> map(to.data(), to.rows(), to.cols());                                         \
    subTo(map, lhs, rhs);                                                                       \
  }                                                                                             \
  template <>                                                                                   \
  template <>                                                                                   \
  void ch5::compiled::OfMatrices<L, R>::scaleAndAddTo(MatrixXd& to, const L& lhs, const R& rhs, \
                                                      const double& factor) {                   \
    Map<MatrixXd> map(to.data(), to.rows(), to.cols());                                         \
    scaleAndAddTo(map, lhs, rhs, factor);                                                       \
  }                                                                                             \
  static_assert(true)
#define CH5_COMPILE_VECTOR(L)                                                                     \
  template <>                                                                                     \
  template <>                                                                                     \
  void ch5::compiled::OfVector<L>::scaleAndAddTo(VectorXd& to, const L& lhs, const VectorXd& rhs, \
                                                 const double& factor) {                          \
    Map<VectorXd> map(to.data(), to.size());                                                      \
    scaleAndAddTo(map, lhs, rhs, factor);                                                         \
  }                                                                                               \
  static_assert(true)

namespace Eigen::internal {
CH5_COMPILED_PRODUCTS(CH5_COMPILE, CH5_COMPILE_VECTOR);
template <>
void compute_inverse<MatrixXd, MatrixXd, Dynamic>::run(const MatrixXd& matrix, MatrixXd& inverse) {
  inverse = matrix.partialPivLu().inverse();
}
}  // namespace Eigen::internal
#endif
