#include "ch5_backend/consistency/first_estimates.h"

#include <algorithm>

#include "ch5_backend/marginalize/scoped_linearization_point.h"

namespace ch5 {

EdgeFirstEstimate::EdgeFirstEstimate(std::shared_ptr<Edge> edge, const Prior* prior)
    : EdgeWithModifiedJacobians(std::move(edge)) {
  for (const auto& vertex : Vertices()) {
    const auto known = std::find(prior->vertices.begin(), prior->vertices.end(), vertex);
    if (known == prior->vertices.end()) continue;
    points_.emplace_back(vertex.get(), &prior->x0[static_cast<size_t>(known - prior->vertices.begin())]);
  }
}

void EdgeFirstEstimate::ComputeJacobians() {
  ScopedLinearizationPoint at_first_estimates;
  for (const auto& [vertex, x0] : points_) at_first_estimates.Move(vertex, *x0);
  CopyJacobians();
}

}  // namespace ch5
