#include "ch5_backend/sparse/steps/edge_normal_equations.h"

#include <algorithm>

#include "ch5_backend/graph/fast_edge.h"
#include "ch5_backend/math/row_products.h"

namespace ch5 {
namespace {

// X = [J r], row by row. `poses`: those of all edges.
void Gather(const EdgePose* poses, const EdgeRecord& record, double* X) {
  const int stride = kernels::RowStride(record.width + 1), rows = record.edge->ResidualDimension();
  int column = 0;
  const auto append = [&](const auto& block) {
    for (Eigen::Index c = 0; c < block.cols(); ++c, ++column) {
      for (int k = 0; k < rows; ++k) X[k * stride + column] = block(k, c);
    }
  };
  if (record.landmark_position < 0) {
    for (size_t i = 0; i < record.edge->Vertices().size(); ++i) append(record.edge->Jacobian(i));
  } else {
    for (int t = record.poses_begin; t < record.poses_end; ++t) {
      append(record.edge->Jacobian(static_cast<size_t>(poses[t].position)));
    }
    append(record.edge->Jacobian(static_cast<size_t>(record.landmark_position)));
  }
  append(record.edge->Residual());
  for (int k = 0; k < rows; ++k) std::fill(X + k * stride + column, X + (k + 1) * stride, 0.0);
}

// Y = W X
void Weigh(const Edge& edge, int columns, const double* X, double* Y) {
  const int rows = edge.ResidualDimension();
  const double w = edge.IsotropicInformation();
  if (w < 0.0) return kernels::MultiplyRows(rows, columns, edge.Information().data(), X, Y);
  for (int i = 0; i < rows * kernels::RowStride(columns); ++i) Y[i] = w * X[i];
}

// [WJ Wr] becomes [W_ρ J  ρ'W r],  W_ρ = ρ'W + 2ρ'' (Wr)(Wr)ᵀ.
void WeighLoss(const RobustWeight& robust, int rows, int width, const double* X, double* Y) {
  const int stride = kernels::RowStride(width + 1);
  for (int c = 0; c < width; ++c) {
    double product = 0.0;  // (Wr)ᵀJ
    for (int k = 0; k < rows; ++k) product += Y[k * stride + width] * X[k * stride + c];
    for (int k = 0; k < rows; ++k) {
      double& y = Y[k * stride + c];
      y = robust.weight * y + robust.rank_one * product * Y[k * stride + width];
    }
  }
  for (int k = 0; k < rows; ++k) Y[k * stride + width] *= robust.weight;
}

// The memory is the thread's, and only grows.
void MultiplyOut(const EdgeRecord& record, const EdgePose* poses, int max_rows, int max_width, double* C) {
  const Edge& edge = *record.edge;
  const int columns = record.width + 1, rows = edge.ResidualDimension();
  thread_local AlignedVector memory;
  const auto size = static_cast<size_t>(max_rows * kernels::RowStride(max_width + 1));
  if (memory.size() < 2 * size) memory.resize(2 * size);
  double *X = memory.data(), *Y = X + size;
  Gather(poses, record, X);
  Weigh(edge, columns, X, Y);
  if (edge.GetLossFunction()) WeighLoss(edge.GetRobustWeight(), rows, record.width, X, Y);
  kernels::NegativeProducts(rows, columns, X, Y, C);
}

}  // namespace

void LinearizeAndMultiplyOut(const Structure& structure, int e, double* C) {
  const EdgeRecord& record = structure.edges[e];
  FastEdge* fast = AsFast(record.edge);
  if (fast && fast->NegativeProductsInto(C)) return;
  if (!record.is_numeric) record.edge->Linearize();
  MultiplyOut(structure, e, C);
}

void LinearizeAndMultiplyOut(Edge* edge, int width, double* C) {
  FastEdge* fast = AsFast(edge);
  if (fast && fast->NegativeProductsInto(C)) return;
  edge->Linearize();
  EdgeRecord record{};
  record.edge = edge;
  record.landmark_position = -1;
  record.width = width;
  MultiplyOut(record, nullptr, edge->ResidualDimension(), width, C);
}

void MultiplyOut(const Structure& structure, int e, double* C) {
  MultiplyOut(structure.edges[e], structure.edge_poses.data(), structure.max_rows, structure.max_width, C);
}

}  // namespace ch5
