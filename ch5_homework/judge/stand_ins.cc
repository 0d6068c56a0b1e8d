// For what a check may be linked without; where the true one is linked, that counts.

#include "ch5_backend/types/visual/edge_reprojection.h"
#include "ch5_homework/judge/compiled_products.h"
#include "ch5_homework/judge/formula/slips.h"

namespace ch5 {

[[gnu::weak]] std::unique_ptr<EdgeBatch> EdgeReprojection::MakeBatch() const { return nullptr; }

namespace homework::formula {

[[gnu::weak]] std::optional<Mistake> FindSlip(const Formula&, const MatXX&, const std::function<bool(const MatXX&)>&,
                                              const std::vector<Formula>&, const std::function<bool(const Text&)>&) {
  return {};
}
[[gnu::weak]] Text TermsOf(const Expression&, Eigen::Index, Eigen::Index) { return {}; }

}  // namespace homework::formula
}  // namespace ch5

#ifndef CH5_NATIVE
namespace Eigen::internal {
using ch5::compiled::ViewOf;
template <>
void apply_block_householder_on_the_left(Block<MatrixXd>& A, const Block<MatrixXd>& V,
                                         const VectorBlock<const VectorXd>& h, bool last_first) {
  ch5::compiled::Reflect(ViewOf<double>(A), ViewOf<const double>(V), h.data(), last_first);
}
template <>
void apply_block_householder_on_the_left(Block<MatrixXd>& A, const Block<MatrixXd>& V,
                                         const Block<VectorXd, Dynamic, 1>& h, bool last_first) {
  ch5::compiled::Reflect(ViewOf<double>(A), ViewOf<const double>(V), h.data(), last_first);
}
template <>
void tridiagonalization_inplace(MatrixXd& A, VectorXd& diagonal, VectorXd& beside, VectorXd&, bool) {
  ch5::compiled::Tridiagonalize(ViewOf<double>(A), diagonal.data(), beside.data());
}
template <>
void partial_lu_inplace(MatrixXd& A, Transpositions<Dynamic>& pivots, int& transpositions) {
  transpositions = ch5::compiled::Factor(ViewOf<double>(A), pivots.indices().data());
}
}  // namespace Eigen::internal
#endif
