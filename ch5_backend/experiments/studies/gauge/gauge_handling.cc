#include "ch5_backend/experiments/studies/gauge/gauge_handling.h"

namespace ch5 {
namespace {

// ∂[p; e_zᵀΔφ]/∂[δp, δθ].  Zhang (2018), §IV
Eigen::Matrix<double, 4, 6> PositionYawJacobian(const VertexReferencePose& pose) {
  Eigen::Matrix<double, 4, 6> C = Eigen::Matrix<double, 4, 6>::Zero();
  C.topLeftCorner<3, 3>().setIdentity();
  C.bottomRightCorner<1, 3>() = pose.DeltaPhiJacobian().row(2);
  return C;
}

}  // namespace

HeldDirections HoldGauge(const std::shared_ptr<VertexReferencePose>& first) {
  return {first, [first] { return PositionYawJacobian(*first); }};
}

EdgeGaugePrior::EdgeGaugePrior(std::shared_ptr<VertexReferencePose> first, double weight)
    : SizedEdge(std::move(first)) {
  SetInformation(weight * Eigen::Matrix4d::Identity());
}

void EdgeGaugePrior::ComputeResidual() {
  const VertexReferencePose& pose = GetVertex<0>();
  r_ << pose.p() - pose.InitialPosition(), pose.DeltaPhi().z();
}

void EdgeGaugePrior::ComputeJacobians() { J<0>() = PositionYawJacobian(GetVertex<0>()); }

MatXX HeldColumns(const Vertices& vertices, const HeldDirections& held) {
  const MatXX C = held.rows();
  MatXX V = MatXX::Zero(TotalLocalDimension(vertices), C.rows());
  int row = 0;
  for (const auto& vertex : vertices) {
    if (vertex == held.vertex) V.middleRows(row, C.cols()) = C.transpose();
    row += vertex->LocalDimension();
  }
  return V;
}

}  // namespace ch5
