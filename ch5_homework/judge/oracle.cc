#include "ch5_homework/judge/oracle.h"

#include "ch5_backend/dense/block_diagonal.h"

namespace ch5::homework {
System StackedNormalEquations(const EdgeList& edges, int size, const std::function<int(const Vertex&)>& row_of) {
  int rows = 0;
  for (const auto& edge : edges) rows += edge->ResidualDimension();
  MatXX J = MatXX::Zero(rows, size);
  MatXX W = MatXX::Zero(rows, rows);
  VecX weighted_residual = VecX::Zero(rows);

  int row = 0;
  for (const auto& edge : edges) {
    edge->ComputeResidual();
    edge->ComputeJacobians();
    double drho;
    MatXX robust_information;
    edge->RobustInfo(&drho, &robust_information);
    const int dim = edge->ResidualDimension();
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      const Vertex& vertex = *edge->Vertices()[i];
      if (vertex.IsFixed()) continue;
      J.block(row, row_of(vertex), dim, vertex.LocalDimension()) = edge->Jacobian(i);
    }
    W.block(row, row, dim, dim) = robust_information;
    weighted_residual.segment(row, dim) = drho * (edge->Information() * edge->Residual());
    row += dim;
  }
  return {J.transpose() * W * J, -J.transpose() * weighted_residual};
}

System StackedNormalEquations(const Graph& graph, int size) {
  return StackedNormalEquations(graph.Edges(), size, [](const Vertex& vertex) { return vertex.OrderingId(); });
}

MatXX Differences(int size, const std::function<MatXX(const VecX& delta)>& f) {
  constexpr double kStep = 1e-5;  // the error kStep² is about that of rounding, 1e-16 / kStep
  MatXX J;
  for (int k = 0; k < size; ++k) {
    const VecX delta = kStep * VecX::Unit(size, k);
    const MatXX column = (f(delta) - f(-delta)) / (2.0 * kStep);
    if (k == 0) J.resize(column.rows(), size);
    J.col(k) = column;
  }
  return J;
}

System RandomSystem(const Ordering& ordering, Random* random) {
  const int p = ordering.dim_poses, m = ordering.dim_landmarks;
  MatXX H_mm = MatXX::Zero(m, m), H_mm_inverse = MatXX::Zero(m, m);
  for (const auto& landmark : ordering.landmarks) {
    const int row = landmark->OrderingId() - p, dim = landmark->LocalDimension();
    H_mm.block(row, row, dim, dim) = RandomPositiveDefinite(dim, random);
    BlockDiagonal inverse(dim);
    inverse.SetInverse(0, H_mm.block(row, row, dim, dim));
    H_mm_inverse.block(row, row, dim, dim) = inverse.Dense();
  }
  const MatXX H_pm = RandomMatrix(p, m, random);

  // The Schur complement is positive definite by construction, and with it H.
  System system{MatXX::Zero(p + m, p + m), RandomMatrix(p + m, 1, random)};
  system.H.topLeftCorner(p, p) = RandomPositiveDefinite(p, random) + H_pm * H_mm_inverse * H_pm.transpose();
  system.H.topRightCorner(p, m) = H_pm;
  system.H.bottomLeftCorner(m, p) = H_pm.transpose();
  system.H.bottomRightCorner(m, m) = H_mm;
  return system;
}

}  // namespace ch5::homework
