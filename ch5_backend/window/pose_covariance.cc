#include "ch5_backend/window/pose_covariance.h"

#include <Eigen/Cholesky>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/window/position_yaw_prior.h"

namespace ch5 {

// The columns of the frame in the inverse of the landmarks' Schur complement, scaled to a unit diagonal.
Mat66 PoseCovariance(const Window& window, const Frame& frame) {
  std::vector<std::shared_ptr<Edge>> edges = window.graph.Edges();
  if (!window.prior_fixes_gauge && !window.gauge_prior) {
    edges.push_back(MakePositionYawPrior(window.frames.front().pose, 1e8));
  }
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
