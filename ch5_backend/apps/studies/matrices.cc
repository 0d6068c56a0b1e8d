#include "ch5_backend/apps/studies/matrices.h"

#include <Eigen/Eigenvalues>

namespace ch5 {

VecX Eigenvalues(const MatXX& H) {
  return Eigen::SelfAdjointEigenSolver<MatXX>(H, Eigen::EigenvaluesOnly).eigenvalues();
}

int NullDimension(const MatXX& H, double relative) {
  const VecX scale = H.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 1.0; });
  const VecX eigenvalues = Eigenvalues(scale.asDiagonal() * H * scale.asDiagonal());
  return static_cast<int>((eigenvalues.array() <= relative * eigenvalues.maxCoeff()).count());
}

FirstRows FirstRowsOf(const Graph& graph) {
  FirstRows rows;
  int size = 0;
  for (const auto& vertex : graph.Vertices()) {
    if (vertex->IsFixed()) continue;
    rows[vertex.get()] = size;
    size += vertex->LocalDimension();
  }
  return rows;
}

MatXX DenseHessian(const Graph& graph, int* pose_rows) {
  const FirstRows row = FirstRowsOf(graph);
  int size = 0;
  *pose_rows = 0;
  for (const auto& vertex : graph.Vertices()) {
    if (vertex->IsFixed()) continue;
    size += vertex->LocalDimension();
    if (vertex->GetRole() == Role::kPose) *pose_rows = size;
  }
  MatXX H = MatXX::Zero(size, size);
  for (const auto& edge : graph.Edges()) {
    edge->Linearize();
    double drho;
    MatXX W;
    edge->RobustInfo(&drho, &W);
    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      for (size_t j = 0; j < vertices.size(); ++j) {
        if (vertices[i]->IsFixed() || vertices[j]->IsFixed()) continue;
        H.block(row.at(vertices[i].get()), row.at(vertices[j].get()), vertices[i]->LocalDimension(),
                vertices[j]->LocalDimension()) += edge->Jacobian(i).transpose() * W * edge->Jacobian(j);
      }
    }
  }
  return H;
}

}  // namespace ch5
