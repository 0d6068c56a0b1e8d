#include "ch5_backend/consistency/observability.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

// The vertex's first estimate, null if the prior does not know it.
const double* FirstOf(const Prior& prior, const std::shared_ptr<Vertex>& vertex) {
  const auto known = std::find(prior.vertices.begin(), prior.vertices.end(), vertex);
  return known == prior.vertices.end() ? nullptr : prior.FirstEstimate(known - prior.vertices.begin()).data();
}

}  // namespace

EdgeObservabilityConstrained::EdgeObservabilityConstrained(std::shared_ptr<Edge> edge, const Prior* prior,
                                                           const Vertex* bystander)
    : EdgeOtherJacobians(std::move(edge)), bystander_(bystander) {
  for (const auto& vertex : Vertices()) {
    const double* first = FirstOf(*prior, vertex);
    now_.push_back(vertex->Parameters().data());
    first_.push_back(first ? first : now_.back());
  }
}

void EdgeObservabilityConstrained::ComputeJacobians() {
  CopyJacobians();
  Vec3 center = Vec3::Zero();  // any will do; near the poses, N₀ᵀN₀ is well conditioned
  for (size_t i = 0; i < Vertices().size(); ++i) {
    if (dynamic_cast<const VertexPose*>(Vertices()[i].get())) center = Eigen::Map<const Vec3>(first_[i]);
  }
  const Directions N0 = DirectionsAt(first_, center), N = DirectionsAt(now_, center);
  const Eigen::Matrix4d normal = N0.transpose() * N0;
  const MatXX told = J_ * (N0 - N);
  J_.noalias() -= told * normal.ldlt().solve(N0.transpose());
}

// ∂(g(ε)·x ⊟ x)/∂ε for x, y, z and yaw about the center, written out (gauge_audit.h).
EdgeObservabilityConstrained::Directions EdgeObservabilityConstrained::DirectionsAt(const std::vector<const double*>& x,
                                                                                    const Vec3& center) const {
  Directions N = Directions::Zero(J_.cols(), 4);
  Eigen::Index row = 0;
  for (size_t i = 0; i < Vertices().size(); ++i) {
    const Vertex* vertex = Vertices()[i].get();
    const Vec3 head = vertex->Dimension() >= 3 ? Vec3(Eigen::Map<const Vec3>(x[i])) : Vec3::Zero();
    if (vertex != bystander_ && dynamic_cast<const VertexPose*>(vertex)) {
      const Qd q(x[i][6], x[i][3], x[i][4], x[i][5]);
      N.block<3, 3>(row, 0).setIdentity();
      N.block<3, 1>(row, 3) = Vec3::UnitZ().cross(head - center);
      N.block<3, 1>(row + 3, 3) = q.conjugate() * Vec3::UnitZ();
    } else if (dynamic_cast<const VertexSpeedBias*>(vertex)) {
      N.block<3, 1>(row, 3) = Vec3::UnitZ().cross(head);
    }
    row += vertex->LocalDimension();
  }
  return N;
}

std::shared_ptr<Edge> ConstrainObservability(std::shared_ptr<Edge> edge, const Prior& prior, const Vertex* bystander) {
  const auto& vertices = edge->Vertices();
  if (std::none_of(vertices.begin(), vertices.end(), [&](const auto& v) { return FirstOf(prior, v) != nullptr; })) {
    return edge;
  }
  return std::make_shared<EdgeObservabilityConstrained>(std::move(edge), &prior, bystander);
}

}  // namespace ch5
