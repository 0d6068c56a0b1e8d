#include "ch5_backend/types/visual/edge_track.h"

#include <Eigen/LU>
#include <algorithm>

namespace ch5 {
namespace {

std::vector<std::shared_ptr<Vertex>> VerticesOf(const std::shared_ptr<VertexInverseDepth>& inverse_depth,
                                                const std::vector<EdgeTrack::View>& views) {
  std::vector<std::shared_ptr<Vertex>> vertices{inverse_depth};
  for (const EdgeTrack::View& view : views) vertices.push_back(view.T_W_B);
  return vertices;
}

// B_j = ∂π(p_Cj)/∂p_Ci ∂p_Ci/∂u_host,  p_Ci = [u_host, 1]/λ
Mat22 HostJacobian(const EdgeTrack::View& host, const EdgeTrack::View& target, double lambda,
                   const RigidMatrix& T_B_C) {
  const PointTransfer transfer(host.x.homogeneous(), lambda, RigidMatrix(*host.T_W_B), RigidMatrix(*target.T_W_B),
                               T_B_C, T_B_C);
  return TransferJacobians(transfer, lambda, T_B_C).ByPointInHost(T_B_C).leftCols<2>() / lambda;
}

}  // namespace

EdgeTrack::EdgeTrack(const std::shared_ptr<VertexInverseDepth>& inverse_depth, const std::vector<View>& views,
                     const Transform& T_B_C, double sigma)
    : Edge(2 * (static_cast<int>(views.size()) - 1), VerticesOf(inverse_depth, views), nullptr, nullptr) {
  if (views.size() < 2 || !(sigma > 0.0)) throw std::invalid_argument("EdgeTrack: two views and a noise are needed");
  for (const auto& vertex : Vertices()) {
    if (!vertex) throw std::invalid_argument("EdgeTrack: a vertex is null");
  }
  const int rows = ResidualDimension();
  MatXX B(rows, 2);
  for (size_t j = 1; j < views.size(); ++j) {
    views_.push_back(std::make_unique<EdgeReprojection>(inverse_depth, views[0].T_W_B, views[j].T_W_B, views[0].x,
                                                        views[j].x, T_B_C));
    B.middleRows<2>(2 * (static_cast<int>(j) - 1)) =
        HostJacobian(views[0], views[j], inverse_depth->InverseDepth(), RigidMatrix(T_B_C));
  }
  const Mat22 inner = (Mat22::Identity() + B.transpose() * B).inverse();
  W_ = (MatXX::Identity(rows, rows) - B * inner * B.transpose()) / (sigma * sigma);
  r_ = VecX::Zero(rows);
  for (const auto& vertex : Vertices()) J_.emplace_back(MatXX::Zero(rows, vertex->LocalDimension()));
  for (size_t i = 0; i < J_.size(); ++i) jacobians_[i] = J_[i].data();
  SetMemory(r_.data(), W_.data());
}

void EdgeTrack::ComputeResidual() {
  for (size_t j = 0; j < views_.size(); ++j) {
    views_[j]->ComputeResidual();
    r_.segment<2>(2 * static_cast<int>(j)) = views_[j]->GetResidual();
  }
}

bool EdgeTrack::InDomain() const {
  return std::all_of(views_.begin(), views_.end(), [](const auto& view) { return view->InDomain(); });
}

void EdgeTrack::Linearize() {
  for (size_t j = 0; j < views_.size(); ++j) {
    const int row = 2 * static_cast<int>(j);
    views_[j]->Linearize();
    r_.segment<2>(row) = views_[j]->GetResidual();
    J_[0].middleRows<2>(row) = views_[j]->Jacobian(0);
    J_[1].middleRows<2>(row) = views_[j]->Jacobian(1);
    J_[j + 2].middleRows<2>(row) = views_[j]->Jacobian(2);
  }
}

}  // namespace ch5
