#include "ch5_backend/marginalize/first_estimates.h"

#include <algorithm>

namespace ch5 {

MovedVertices::MovedVertices(const Prior* prior) {
  for (size_t i = 0; prior && i < prior->vertices.size(); ++i) Move(prior->vertices[i].get(), prior->x0[i]);
}

MovedVertices::~MovedVertices() {
  for (auto it = before_.rbegin(); it != before_.rend(); ++it) it->first->Parameters() = it->second;
}

void MovedVertices::Move(Vertex* vertex, const VecX& x) {
  before_.emplace_back(vertex, vertex->Parameters());
  vertex->Parameters() = x;
}

EdgeFirstEstimate::EdgeFirstEstimate(std::shared_ptr<Edge> edge, const Prior* prior)
    : Edge(edge->ResidualDimension(), edge->Vertices(), nullptr, nullptr), edge_(std::move(edge)) {
  for (const auto& vertex : Vertices()) {
    const auto known = std::find(prior->vertices.begin(), prior->vertices.end(), vertex);
    if (known == prior->vertices.end()) continue;
    points_.emplace_back(vertex.get(), &prior->x0[static_cast<size_t>(known - prior->vertices.begin())]);
  }
  r_ = VecX::Zero(ResidualDimension());
  W_ = edge_->Information();
  for (const auto& vertex : Vertices()) J_.emplace_back(MatXX::Zero(ResidualDimension(), vertex->LocalDimension()));
  for (size_t i = 0; i < J_.size(); ++i) jacobians_[i] = J_[i].data();
  SetMemory(r_.data(), W_.data());
  if (edge_->GetLossFunction()) {
    SetLossFunction(std::shared_ptr<const LossFunction>(edge_, edge_->GetLossFunction()));  // lives as long as the edge
  }
}

void EdgeFirstEstimate::ComputeResidual() {
  edge_->ComputeResidual();
  r_ = edge_->Residual();
}

void EdgeFirstEstimate::ComputeJacobians() {
  MovedVertices scope;
  for (const auto& [vertex, x0] : points_) scope.Move(vertex, *x0);
  edge_->Linearize();
  for (size_t i = 0; i < J_.size(); ++i) J_[i] = edge_->Jacobian(i);
}

}  // namespace ch5
