#include "ch5_backend/consistency/first_estimates.h"

#include <algorithm>

namespace ch5 {

EdgeOtherJacobians::EdgeOtherJacobians(std::shared_ptr<Edge> edge)
    : Edge(edge->ResidualDimension(), edge->Vertices(), nullptr, nullptr),
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
  if (edge_->GetLossFunction()) {
    SetLossFunction(std::shared_ptr<const LossFunction>(edge_, edge_->GetLossFunction()));  // lives as long as the edge
  }
}

void EdgeOtherJacobians::ComputeResidual() {
  edge_->ComputeResidual();
  r_ = edge_->Residual();
}

void EdgeOtherJacobians::CopyJacobians() {
  edge_->Linearize();
  Eigen::Index column = 0;
  for (size_t i = 0; i < Vertices().size(); ++i) {
    const auto J_i = edge_->Jacobian(i);
    J_.middleCols(column, J_i.cols()) = J_i;
    column += J_i.cols();
  }
}

EdgeFirstEstimate::EdgeFirstEstimate(std::shared_ptr<Edge> edge, const Prior* prior)
    : EdgeOtherJacobians(std::move(edge)) {
  for (const auto& vertex : Vertices()) {
    const auto known = std::find(prior->vertices.begin(), prior->vertices.end(), vertex);
    if (known == prior->vertices.end()) continue;
    points_.emplace_back(vertex.get(), &prior->x0[static_cast<size_t>(known - prior->vertices.begin())]);
  }
}

void EdgeFirstEstimate::ComputeJacobians() {
  MovedVertices scope;
  for (const auto& [vertex, x0] : points_) scope.Move(vertex, *x0);
  CopyJacobians();
}

}  // namespace ch5
