#include "ch5_backend/experiments/studies/homework/graded_priors.h"

#include <set>

#include "ch5_backend/marginalize/marginalization_error.h"
#include "ch5_backend/marginalize/marginalization_info.h"

namespace ch5 {
namespace {

class EdgeMarginalizationError : public EdgePrior {
 public:
  explicit EdgeMarginalizationError(const MarginalizationError& error) : EdgePrior(error.GetPrior()), error_(error) {}
  void ComputeResidual() override { SetResidual(error_.Residual(error_.ComputeDeltaChi())); }

 private:
  MarginalizationError error_;
};

}  // namespace

std::shared_ptr<EdgePrior> PriorByMarginalizationError(const std::vector<std::shared_ptr<Edge>>& edges,
                                                       const std::vector<std::shared_ptr<Vertex>>& drop) {
  MarginalizationError error;
  for (const auto& edge : edges) error.AddResidualBlock(edge);
  std::vector<std::shared_ptr<Vertex>> free;
  for (const auto& vertex : drop) {
    if (!vertex->IsFixed()) free.push_back(vertex);
  }
  error.MarginalizeOut(free);
  error.UpdateErrorComputation();
  return std::make_shared<EdgeMarginalizationError>(error);
}

std::shared_ptr<EdgePrior> PriorByMarginalizationInfo(const std::vector<std::shared_ptr<Edge>>& edges,
                                                      const std::vector<std::shared_ptr<Vertex>>& drop) {
  const std::set<std::shared_ptr<Vertex>> dropped(drop.begin(), drop.end());
  MarginalizationInfo info;
  for (const auto& edge : edges) {
    ResidualBlockInfo block{edge, {}};
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      if (dropped.count(edge->Vertices()[i]) > 0) block.drop_set.push_back(static_cast<int>(i));
    }
    info.AddResidualBlockInfo(block);
  }
  info.PreMarginalize();
  info.Marginalize();
  return std::make_shared<EdgePrior>(info.GetParameterBlocks());
}

}  // namespace ch5
