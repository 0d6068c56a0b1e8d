#include "ch5_backend/window/place.h"

#include <Eigen/Cholesky>

#include "ch5_backend/marginalize/marginalize.h"

namespace ch5 {

// The yaw's axis is gravity's, seen from the body: δθ is a right perturbation.
std::shared_ptr<Edge> HoldGauge(const std::shared_ptr<VertexPose>& pose, double information) {
  Prior prior;
  prior.vertices = {pose};
  prior.x0 = {pose->GetEstimate()};
  prior.J = MatXX::Zero(4, 6);
  prior.J.topLeftCorner<3, 3>().setIdentity();
  prior.J.bottomRightCorner<1, 3>() = pose->R().row(2);
  prior.J *= std::sqrt(information);
  prior.r0 = VecX::Zero(4);
  return std::make_shared<EdgePrior>(std::move(prior));
}

// The columns of the frame in the inverse of the landmarks' Schur complement, scaled to a unit diagonal.
Mat66 PoseCovariance(const Window& window, const WindowFrame& frame) {
  std::vector<std::shared_ptr<Edge>> edges = window.graph.Edges();
  if (!window.knows_place && !window.gauge) edges.push_back(HoldGauge(window.frames.front().pose, 1e8));
  std::vector<std::shared_ptr<Vertex>> landmarks;
  for (const auto& vertex : window.graph.Vertices()) {
    if (vertex->GetRole() == Role::kLandmark) landmarks.push_back(vertex);
  }
  const MarginalSystem system = EliminateVertices(edges, landmarks);
  const VecX p_inverse = ScalingOf(system.H).cwiseInverse();
  const Eigen::LDLT<MatXX> ldlt(p_inverse.asDiagonal() * system.H * p_inverse.asDiagonal());
  Eigen::Index row = 0;
  for (const auto& vertex : system.kept) {
    if (vertex == frame.pose) break;
    row += vertex->LocalDimension();
  }
  MatXX columns = MatXX::Zero(system.H.rows(), 6);
  columns.middleRows<6>(row).diagonal() = p_inverse.segment<6>(row);
  return p_inverse.segment<6>(row).asDiagonal() * ldlt.solve(columns).middleRows<6>(row);
}

}  // namespace ch5
