#include "ch5_backend/experiments/studies/gauge/gauge_handling.h"

#include <Eigen/LU>
#include <stdexcept>

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

std::vector<HeldDirections> HoldGauge(const std::shared_ptr<VertexReferencePose>& first) {
  return {{first, [first] { return PositionYawJacobian(*first); }}};
}

std::vector<HeldDirections> HoldGauge(const std::shared_ptr<VertexReferencePose>& first,
                                      const std::shared_ptr<VertexPose>& second) {
  const Vec3 baseline = second->p() - first->p();
  if (!(baseline.norm() > 0.0)) throw std::invalid_argument("HoldGauge: the two poses are at one place");
  MatXX along = MatXX::Zero(1, 6);
  along.leftCols<3>() = baseline.normalized().transpose();
  return {{first, [] { return MatXX::Identity(6, 6); }}, {second, [along] { return along; }}};
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

MatXX HeldColumns(const Vertices& vertices, const std::vector<HeldDirections>& held) {
  MatXX V(TotalLocalDimension(vertices), 0);
  for (const HeldDirections& h : held) {
    const MatXX C = h.rows();
    V.conservativeResize(Eigen::NoChange, V.cols() + C.rows());
    V.rightCols(C.rows()).setZero();
    int row = 0;
    for (const auto& vertex : vertices) {
      if (vertex == h.vertex) V.block(row, V.cols() - C.rows(), C.cols(), C.rows()) = C.transpose();
      row += vertex->LocalDimension();
    }
  }
  return V;
}

GaugeCovariance::GaugeCovariance(Covariance* covariance, GaugeGroup group, const std::vector<HeldDirections>& held)
    : covariance_(covariance) {
  Vertices vertices = covariance->GetOrdering().poses;
  const Vertices& landmarks = covariance->GetOrdering().landmarks;
  vertices.insert(vertices.end(), landmarks.begin(), landmarks.end());
  const MatXX U = GaugeNullSpace(vertices, group);
  const MatXX V = held.empty() ? U : HeldColumns(vertices, held);
  const Eigen::FullPivLU<MatXX> VtU(V.transpose() * U);
  if (V.cols() != U.cols() || !VtU.isInvertible()) {
    throw std::invalid_argument("GaugeCovariance: the held directions do not hold the gauge");
  }
  UG_ = U * VtU.inverse();
  SV_ = covariance->Multiply(V);
  B_ = V.transpose() * SV_;
}

MatXX GaugeCovariance::Block(const Vertex& a, const Vertex& b) {
  const auto rows_of = [](const MatXX& A, const Vertex& v) { return A.middleRows(v.OrderingId(), v.LocalDimension()); };
  MatXX block = covariance_->Block(a, b);  // refuses vertices that take no part
  const MatXX UG_a = rows_of(UG_, a), UG_b = rows_of(UG_, b);
  block -= UG_a * rows_of(SV_, b).transpose() + rows_of(SV_, a) * UG_b.transpose();
  return block + UG_a * B_ * UG_b.transpose();
}

}  // namespace ch5
