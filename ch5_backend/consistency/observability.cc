#include "ch5_backend/consistency/observability.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "ch5_backend/types/vertices.h"

namespace ch5 {
namespace {

// Null if the prior does not hold the vertex.
const double* FirstEstimateOf(const Prior& prior, const std::shared_ptr<Vertex>& vertex) {
  const auto known = std::find(prior.vertices.begin(), prior.vertices.end(), vertex);
  return known == prior.vertices.end() ? nullptr : prior.FirstEstimate(known - prior.vertices.begin()).data();
}

}  // namespace

// ∂(g(ε)·x ⊟ x)/∂ε of g(ε): p ↦ c + R_z(ε)(p − c):  δp = e_z × (p − c),  δθ = Rᵀe_z,  δv = e_z × v
Eigen::Matrix<double, Eigen::Dynamic, 4> PositionYawDirections(const std::vector<std::shared_ptr<Vertex>>& vertices,
                                                               const std::vector<const double*>& x,
                                                               const std::vector<const Vertex*>& local_poses,
                                                               const Vec3& center) {
  Eigen::Index rows = 0;
  for (const auto& vertex : vertices) rows += vertex->LocalDimension();
  Eigen::Matrix<double, Eigen::Dynamic, 4> N = Eigen::Matrix<double, Eigen::Dynamic, 4>::Zero(rows, 4);
  Eigen::Index row = 0;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Vertex* vertex = vertices[i].get();
    const bool is_local = std::find(local_poses.begin(), local_poses.end(), vertex) != local_poses.end();
    if (!is_local && dynamic_cast<const VertexPose*>(vertex)) {
      const Vec3 p = Eigen::Map<const Vec3>(x[i]);
      const Qd q(x[i][6], x[i][3], x[i][4], x[i][5]);
      N.block<3, 3>(row, 0).setIdentity();
      N.block<3, 1>(row, 3) = Vec3::UnitZ().cross(p - center);
      N.block<3, 1>(row + 3, 3) = q.conjugate() * Vec3::UnitZ();
    } else if (dynamic_cast<const VertexSpeedBias*>(vertex)) {
      N.block<3, 1>(row, 3) = Vec3::UnitZ().cross(Vec3(Eigen::Map<const Vec3>(x[i])));
    }
    row += vertex->LocalDimension();
  }
  return N;
}

namespace {

class EdgeObservabilityConstrained : public Edge {
 public:
  EdgeObservabilityConstrained(std::shared_ptr<Edge> edge, const Prior& prior,
                               const std::vector<const Vertex*>& local_poses);
  void ComputeResidual() override {
    edge_->ComputeResidual();
    r_ = edge_->Residual();
  }
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return edge_->TypeInfo(); }

 private:
  std::shared_ptr<Edge> edge_;
  VecX r_;
  MatXX W_, J_;  // J': the vertices' blocks side by side
  std::vector<const Vertex*> local_poses_;
  std::vector<const double*> now_, first_;  // parameters of each vertex
};

EdgeObservabilityConstrained::EdgeObservabilityConstrained(std::shared_ptr<Edge> edge, const Prior& prior,
                                                           const std::vector<const Vertex*>& local_poses)
    : Edge(edge->ResidualDimension(), std::vector<std::shared_ptr<Vertex>>(edge->Vertices()), nullptr, nullptr),
      edge_(std::move(edge)),
      r_(VecX::Zero(ResidualDimension())),
      W_(edge_->Information()),
      local_poses_(local_poses) {
  int columns = 0;
  for (const auto& vertex : Vertices()) {
    const double* first = FirstEstimateOf(prior, vertex);
    now_.push_back(vertex->Parameters().data());
    first_.push_back(first ? first : now_.back());
    columns += vertex->LocalDimension();
  }
  J_ = MatXX::Zero(ResidualDimension(), columns);
  double* column = J_.data();
  for (size_t i = 0; i < Vertices().size(); ++i) {
    jacobians_[i] = column;
    column += ResidualDimension() * Vertices()[i]->LocalDimension();
  }
  SetMemory(r_.data(), W_.data());
  if (edge_->GetLossFunction()) {  // shares the ownership of the edge, which keeps its loss alive
    SetLossFunction(std::shared_ptr<const LossFunction>(edge_, edge_->GetLossFunction()));
  }
}

void EdgeObservabilityConstrained::ComputeJacobians() {
  edge_->Linearize();
  Eigen::Index column = 0;
  Vec3 center = Vec3::Zero();  // any point spans the same space; near the poses, N₀ᵀN₀ is well conditioned
  for (size_t i = 0; i < Vertices().size(); ++i) {
    const auto J_i = edge_->Jacobian(i);
    J_.middleCols(column, J_i.cols()) = J_i;
    column += J_i.cols();
    if (dynamic_cast<const VertexPose*>(Vertices()[i].get())) center = Eigen::Map<const Vec3>(first_[i]);
  }
  const auto N0 = PositionYawDirections(Vertices(), first_, local_poses_, center);
  const auto N = PositionYawDirections(Vertices(), now_, local_poses_, center);
  const Eigen::Matrix4d normal = N0.transpose() * N0;
  const MatXX J_dN = J_ * (N0 - N);
  J_.noalias() -= J_dN * normal.ldlt().solve(N0.transpose());
}

}  // namespace

std::shared_ptr<Edge> ConstrainObservability(std::shared_ptr<Edge> edge, const Prior& prior,
                                             const std::vector<const Vertex*>& local_poses) {
  const auto& vertices = edge->Vertices();
  if (std::none_of(vertices.begin(), vertices.end(),
                   [&](const auto& v) { return FirstEstimateOf(prior, v) != nullptr; })) {
    return edge;
  }
  return std::make_shared<EdgeObservabilityConstrained>(std::move(edge), prior, local_poses);
}

}  // namespace ch5
