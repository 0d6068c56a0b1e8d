#pragma once
/// The covariance of several vertices together.

#include "ch5_backend/sparse/covariance.h"

namespace ch5 {

/// E[δ δᵀ] of these vertices' increments, one below the other: symmetric, Σ LocalDimension square.
/// @throws CovarianceError as Covariance::Blocks
inline MatXX JointCovariance(const std::vector<std::shared_ptr<Vertex>>& vertices, Covariance* covariance) {
  Eigen::Index size = 0;
  for (const auto& vertex : vertices) size += vertex ? vertex->LocalDimension() : 0;
  MatXX joint(size, size);
  Eigen::Index row = 0;
  for (size_t i = 0; i < vertices.size(); ++i) {
    Eigen::Index column = 0;
    for (size_t j = 0; j <= i; ++j) {
      const MatXX block = covariance->Blocks({{vertices[i], vertices[j]}}).front();
      joint.block(row, column, block.rows(), block.cols()) = block;
      joint.block(column, row, block.cols(), block.rows()) = block.transpose();
      column += block.cols();
    }
    row += vertices[i]->LocalDimension();
  }
  return joint;
}

}  // namespace ch5
