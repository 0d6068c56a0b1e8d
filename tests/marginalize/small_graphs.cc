#include "tests/marginalize/small_graphs.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5 {

double RelativeError(const MatXX& A, const MatXX& B) { return (A - B).norm() / (1e-300 + B.norm()); }

MatXX NormalMatrix(int rows, int columns, Random* random) {
  return MatXX::NullaryExpr(rows, columns, [random] { return random->Normal(); });
}

LinearEdge::LinearEdge(const std::vector<std::shared_ptr<Vertex>>& vertices, std::vector<MatXX> A, const VecX& z)
    : Edge(static_cast<int>(z.size()), vertices, nullptr, nullptr),
      A_(std::move(A)),
      z_(z),
      r_(z.size()),
      W_(MatXX::Identity(z.size(), z.size())) {
  SetMemory(r_.data(), W_.data());
  for (size_t i = 0; i < A_.size(); ++i) jacobians_[i] = A_[i].data();
}

void LinearEdge::ComputeResidual() {
  r_ = -z_;
  for (size_t i = 0; i < A_.size(); ++i) r_ += A_[i] * vertices_[i]->Parameters();
}

SmallWindow::SmallWindow(uint64_t seed, int frames) {
  Random random(seed);
  // A bias walk so slow that its information swamps everything would only test the cancellation of large numbers.
  const ImuNoise noise{0.08, 0.004, 0.02, 0.002, false};
  for (int k = 0; k < frames; ++k) {
    // Drawn by name: in which order a call's arguments are drawn is the compiler's choice.
    const Vec3 p = Vec3(0.3 * k, 0, 0) + NormalVector(&random, 0.02), phi = NormalVector(&random, 0.1);
    poses.push_back(std::make_shared<VertexPose>(ExpSO3(phi), p));
    Vec9 sb;
    sb << Vec3(1.5, 0, 0) + NormalVector(&random, 0.05), NormalVector(&random, 0.05), NormalVector(&random, 0.01);
    speed_biases.push_back(std::make_shared<VertexSpeedBias>(sb));
    graph.AddVertex(poses.back());
    graph.AddVertex(speed_biases.back());
  }
  extrinsic = std::make_shared<VertexPose>(ExpSO3({0.02, -0.01, 0.03}), Vec3(0.05, 0.02, 0.01));
  graph.AddVertex(extrinsic);

  auto prior = std::make_shared<EdgeSE3Prior>(poses[0], poses[0]->q(), poses[0]->p() + Vec3(0.01, 0, 0));
  prior->SetInformation(1e4 * Mat66::Identity());
  graph.AddEdge(prior);
  for (size_t k = 0; k + 1 < poses.size(); ++k) {
    auto imu = std::make_shared<Preintegration>(ImuSample{0.0, Vec3(0.1, 0, 9.8), Vec3(0, 0.05, 0)}, Vec3::Zero(),
                                                Vec3::Zero(), noise);
    for (int n = 0; n < 40; ++n) imu->Add({0.005, Vec3(0.1, 0.05 * n, 9.8), Vec3(0, 0.05, 0.01 * n)});
    graph.AddEdge(std::make_shared<EdgeImu>(poses[k], speed_biases[k], poses[k + 1], speed_biases[k + 1], imu));
  }
  const auto cauchy = std::make_shared<CauchyLoss>(1.0);
  for (size_t l = 0; l < 12; ++l) {
    const size_t host = l % 2;
    landmarks.push_back(std::make_shared<VertexInverseDepth>(random.Uniform(0.1, 0.5)));
    graph.AddVertex(landmarks.back());
    const Vec2 u_host = NormalVector(&random, 0.3).head<2>();
    for (size_t k = host + 1; k < poses.size(); ++k) {
      auto edge = std::make_shared<EdgeReprojectionExtrinsic>(landmarks[l], poses[host], poses[k], extrinsic, u_host,
                                                              u_host + NormalVector(&random, 0.05).head<2>());
      edge->SetInformation(300.0 * Mat22::Identity());
      edge->SetLossFunction(cauchy);
      graph.AddEdge(edge);
    }
  }
}

std::vector<std::shared_ptr<Vertex>> SmallWindow::Oldest() const {
  std::vector<std::shared_ptr<Vertex>> drop{poses[0], speed_biases[0]};
  for (size_t l = 0; l < landmarks.size(); l += 2) drop.push_back(landmarks[l]);
  return drop;
}

std::vector<std::shared_ptr<Edge>> SmallWindow::EdgesAt(const std::vector<std::shared_ptr<Vertex>>& vertices) const {
  std::vector<std::shared_ptr<Edge>> edges;
  for (const auto& edge : graph.Edges()) {
    for (const auto& v : edge->Vertices()) {
      if (std::find(vertices.begin(), vertices.end(), v) == vertices.end()) continue;
      edges.push_back(edge);
      break;
    }
  }
  return edges;
}

DenseSystem DenseNormalEquations(const std::vector<std::shared_ptr<Edge>>& edges,
                                 std::vector<std::shared_ptr<Vertex>> order,
                                 const std::vector<std::shared_ptr<Vertex>>& dropped) {
  order.insert(order.end(), dropped.begin(), dropped.end());
  std::map<const Vertex*, int> row;
  int n = 0;
  for (const auto& v : order) {
    row[v.get()] = n;
    n += v->LocalDimension();
  }
  DenseSystem system{MatXX::Zero(n, n), VecX::Zero(n)};
  for (const auto& edge : edges) {
    edge->ComputeResidual();
    edge->ComputeJacobians();
    MatXX J = MatXX::Zero(edge->ResidualDimension(), n);
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      const Vertex& v = *edge->Vertices()[i];
      if (row.count(&v)) J.middleCols(row[&v], v.LocalDimension()) = edge->Jacobian(i);
    }
    const VecX r = edge->Residual();
    const MatXX W = edge->Information();
    const double s = r.dot(W * r);
    const Rho rho = edge->GetLossFunction() ? edge->GetLossFunction()->Evaluate(s) : Rho{s, 1.0, 0.0};
    MatXX W_rho = rho[1] * W;
    if (rho[1] + 2.0 * rho[2] * s > 0.0) W_rho += 2.0 * rho[2] * (W * r) * (W * r).transpose();
    system.H += J.transpose() * W_rho * J;
    system.b -= rho[1] * J.transpose() * W * r;
  }
  return system;
}

MatXX Schur(const MatXX& H, Eigen::Index n) {
  const Eigen::Index m = H.rows() - n;
  return H.topLeftCorner(n, n) -
         H.topRightCorner(n, m) * H.bottomRightCorner(m, m).inverse() * H.bottomLeftCorner(m, n);
}

VecX SchurB(const MatXX& H, const VecX& b, Eigen::Index n) {
  const Eigen::Index m = H.rows() - n;
  return b.head(n) - H.topRightCorner(n, m) * H.bottomRightCorner(m, m).inverse() * b.tail(m);
}

}  // namespace ch5
