#pragma once
/// The one oracle of all Jacobians: central differences through the vertices' own ⊞.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "ch5_backend/graph/edge.h"

namespace ch5 {

// f' ≈ (8 (f(h) − f(−h)) − (f(2h) − f(−2h))) / 12h: error O(h⁴), and ε/h = 2e-12 from rounding.
inline void ExpectJacobiansAreDerivatives(Edge* edge, const std::string& where = "a state") {
  edge->ComputeResidual();
  edge->ComputeJacobians();
  for (size_t i = 0; i < edge->Vertices().size(); ++i) {
    Vertex& vertex = *edge->Vertices()[i];
    const MatXX analytic = edge->Jacobian(i);
    MatXX numeric(analytic.rows(), analytic.cols());
    const VecX x0 = vertex.Parameters();
    for (int k = 0; k < vertex.LocalDimension(); ++k) {
      const double h = 1e-4;
      const auto at = [&](double step) -> VecX {
        const VecX delta = step * VecX::Unit(vertex.LocalDimension(), k);
        vertex.Plus(delta.data());
        edge->ComputeResidual();
        vertex.Parameters() = x0;
        return edge->Residual();
      };
      numeric.col(k) = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
    }
    // Rounding of a residual of size ‖r‖ gives ε‖r‖/h, some 2e-12 of it.
    const double scale = std::max({1.0, analytic.cwiseAbs().maxCoeff(), edge->Residual().norm()});
    EXPECT_LT((analytic - numeric).cwiseAbs().maxCoeff(), 2e-9 * scale)
        << edge->TypeInfo() << ", vertex " << i << " at " << where << "\nanalytic\n"
        << analytic << "\nnumeric\n"
        << numeric;
  }
  edge->ComputeResidual();
}

}  // namespace ch5
