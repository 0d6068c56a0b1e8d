#include "ch5_backend/marginalize/edge_prior.h"

#include <stdexcept>

namespace ch5 {

EdgePrior::EdgePrior(Prior prior)
    : Edge(static_cast<int>(prior.r0.size()), prior.vertices, nullptr, nullptr), prior_(std::move(prior)) {
  const auto rows = prior_.r0.size();
  Eigen::Index columns = 0;
  if (prior_.x0.size() != prior_.vertices.size()) throw std::invalid_argument("EdgePrior: one x0 a vertex is needed");
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    if (!prior_.vertices[i] || prior_.x0[i].size() != prior_.vertices[i]->Dimension()) {
      throw std::invalid_argument("EdgePrior: x0 " + std::to_string(i) + " does not fit its vertex");
    }
    columns += prior_.vertices[i]->LocalDimension();
  }
  if (prior_.J.rows() != rows || prior_.J.cols() != columns) {
    throw std::invalid_argument("EdgePrior: J must be " + std::to_string(rows) + "x" + std::to_string(columns) +
                                ", got " + std::to_string(prior_.J.rows()) + "x" + std::to_string(prior_.J.cols()));
  }
  r_ = prior_.r0;
  W_ = MatXX::Identity(rows, rows);
  J_ = prior_.J;
  SetMemory(r_.data(), W_.data());
  double* column = J_.data();
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    jacobians_[i] = column;
    column += rows * prior_.vertices[i]->LocalDimension();
  }
}

void EdgePrior::ComputeResidual() {
  r_ = prior_.r0;
  Eigen::Index column = 0;
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    const Vertex& vertex = *prior_.vertices[i];
    r_.noalias() += prior_.J.middleCols(column, vertex.LocalDimension()) * vertex.Minus(prior_.x0[i]);
    column += vertex.LocalDimension();
  }
}

void EdgePrior::ComputeJacobians() {
  if (keep_jacobian_) {
    J_ = prior_.J;
    return;
  }
  Eigen::Index column = 0;
  for (size_t i = 0; i < prior_.vertices.size(); ++i) {
    const Vertex& vertex = *prior_.vertices[i];
    const auto J_i = prior_.J.middleCols(column, vertex.LocalDimension());
    J_.middleCols(column, vertex.LocalDimension()).noalias() = J_i * vertex.MinusJacobian(prior_.x0[i]);
    column += vertex.LocalDimension();
  }
}

}  // namespace ch5
