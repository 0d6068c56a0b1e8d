#include "ch5_backend/consistency/modified_jacobians.h"

namespace ch5 {

EdgeWithModifiedJacobians::EdgeWithModifiedJacobians(std::shared_ptr<Edge> edge)
    : Edge(edge->ResidualDimension(), std::vector<std::shared_ptr<Vertex>>(edge->Vertices()), nullptr, nullptr),
      edge_(std::move(edge)),
      r_(VecX::Zero(ResidualDimension())),
      W_(edge_->Information()) {
  int columns = 0;
  for (const auto& vertex : Vertices()) columns += vertex->LocalDimension();
  J_ = MatXX::Zero(ResidualDimension(), columns);
  double* column = J_.data();
  for (size_t i = 0; i < Vertices().size(); ++i) {
    jacobians_[i] = column;
    column += ResidualDimension() * Vertices()[i]->LocalDimension();
  }
  SetMemory(r_.data(), W_.data());
  if (edge_->GetLossFunction()) {  // shares the ownership of the edge, which keeps its loss alive
    SetLossFunction(std::shared_ptr<const LossFunction>(edge_, edge_->GetLossFunction()));
  }
}

void EdgeWithModifiedJacobians::ComputeResidual() {
  edge_->ComputeResidual();
  r_ = edge_->Residual();
}

void EdgeWithModifiedJacobians::CopyJacobians() {
  edge_->Linearize();
  Eigen::Index column = 0;
  for (size_t i = 0; i < Vertices().size(); ++i) {
    const auto J_i = edge_->Jacobian(i);
    J_.middleCols(column, J_i.cols()) = J_i;
    column += J_i.cols();
  }
}

}  // namespace ch5
