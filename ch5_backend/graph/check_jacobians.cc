#include "ch5_backend/graph/check_jacobians.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace ch5 {
namespace {

MatXX DifferentiateNumerically(Edge* edge, Vertex* vertex) {
  constexpr double h = 1e-4;
  MatXX J(edge->ResidualDimension(), vertex->LocalDimension());
  const VecX x0 = vertex->Parameters();
  for (int k = 0; k < vertex->LocalDimension(); ++k) {
    const auto at = [&](double step) -> VecX {
      const VecX delta = step * VecX::Unit(vertex->LocalDimension(), k);
      vertex->Plus(delta.data());
      edge->ComputeResidual();
      vertex->Parameters() = x0;
      return edge->Residual();
    };
    J.col(k) = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
  }
  edge->ComputeResidual();
  return J;
}

}  // namespace

JacobianCheck CheckJacobians(Edge* edge, double tolerance) {
  if (!edge) throw std::invalid_argument("CheckJacobians: the edge is null");
  JacobianCheck check;
  std::ostringstream message;
  edge->ComputeResidual();
  edge->ComputeJacobians();
  for (size_t i = 0; i < edge->Vertices().size(); ++i) {
    const MatXX J = edge->Jacobian(i);
    const MatXX numeric = DifferentiateNumerically(edge, edge->Vertices()[i].get());
    const double scale = std::max({1.0, J.cwiseAbs().maxCoeff(), edge->Residual().norm()});
    const double off = (J - numeric).cwiseAbs().maxCoeff() / scale;
    if (!(off <= check.worst)) check.worst = off;
    if (off < tolerance) continue;
    message << edge->TypeInfo() << ", vertex " << i << ":\nits Jacobian\n" << J << "\nnumeric\n" << numeric << "\n";
  }
  check.message = message.str();
  return check;
}

}  // namespace ch5
