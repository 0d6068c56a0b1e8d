// For what a check may be linked without; where the true one is linked, that counts.

#include "ch5_backend/types/visual/edge_reprojection.h"
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
