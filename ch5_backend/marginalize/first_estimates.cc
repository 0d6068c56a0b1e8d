#include "ch5_backend/marginalize/first_estimates.h"

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/marginalize/scoped_linearization_point.h"

namespace ch5 {
namespace {

class HeldEdge : public Edge {
 public:
  HeldEdge(std::shared_ptr<Edge> edge, std::shared_ptr<const std::unordered_map<const Vertex*, VecX>> first)
      : Edge(edge->ResidualDimension(), std::vector<std::shared_ptr<Vertex>>(edge->Vertices()), nullptr, nullptr),
        edge_(std::move(edge)),
        first_(std::move(first)),
        r_(VecX::Zero(ResidualDimension())),
        W_(edge_->Information()) {
    for (size_t i = 0; i < Vertices().size(); ++i) {
      J_.emplace_back(ResidualDimension(), Vertices()[i]->LocalDimension());
      jacobians_[i] = J_.back().data();
    }
    SetMemory(r_.data(), W_.data());
    if (const LossFunction* loss = edge_->GetLossFunction()) {
      SetLossFunction(std::shared_ptr<const LossFunction>(edge_, loss));  // which keeps it alive
    }
  }
  void ComputeResidual() override {
    edge_->ComputeResidual();
    r_ = edge_->Residual();
  }
  void ComputeJacobians() override {
    ScopedLinearizationPoint at_first;
    for (const auto& vertex : Vertices()) {
      if (const auto known = first_->find(vertex.get()); known != first_->end()) {
        at_first.Move(vertex.get(), known->second);
      }
    }
    edge_->Linearize();
    for (size_t i = 0; i < J_.size(); ++i) J_[i] = edge_->Jacobian(i);
  }
  std::string TypeInfo() const override { return edge_->TypeInfo(); }

 private:
  std::shared_ptr<Edge> edge_;
  std::shared_ptr<const std::unordered_map<const Vertex*, VecX>> first_;
  VecX r_;
  MatXX W_;
  std::vector<MatXX> J_;
};

}  // namespace

std::shared_ptr<Edge> FirstEstimates::Hold(std::shared_ptr<Edge> edge) const {
  if (!edge) throw GraphError("FirstEstimates: the edge is null");
  return std::make_shared<HeldEdge>(std::move(edge), states_);
}

std::shared_ptr<EdgePrior> FirstEstimates::MarginalizeInto(Graph* graph,
                                                           const std::vector<std::shared_ptr<Vertex>>& drop) {
  auto prior = ch5::MarginalizeInto(graph, drop);
  for (const auto& vertex : drop) states_->erase(vertex.get());
  if (!prior) return nullptr;
  prior->KeepJacobian(true);
  const Prior& values = prior->GetPrior();
  for (size_t i = 0; i < values.vertices.size(); ++i) states_->emplace(values.vertices[i].get(), values.x0[i]);
  return prior;
}

}  // namespace ch5
