#pragma once
/// Small graphs to marginalise in.

#include <gtest/gtest.h>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/types/edge_imu.h"
#include "ch5_backend/types/edge_reprojection.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/world/simulate/random.h"

namespace ch5 {

inline double RelativeError(const MatXX& A, const MatXX& B) { return (A - B).norm() / (1e-300 + B.norm()); }

/// r = Σ A_i x_i − z, for problems whose batch solution is known exactly.
class LinearEdge : public Edge {
 public:
  LinearEdge(const std::vector<std::shared_ptr<Vertex>>& vertices, std::vector<MatXX> A, const VecX& z)
      : Edge(static_cast<int>(z.size()), vertices, nullptr, nullptr),
        A_(std::move(A)),
        z_(z),
        r_(z.size()),
        W_(MatXX::Identity(z.size(), z.size())) {
    SetMemory(r_.data(), W_.data());
    for (size_t i = 0; i < A_.size(); ++i) jacobians_[i] = A_[i].data();
  }
  void ComputeResidual() override {
    r_ = -z_;
    for (size_t i = 0; i < A_.size(); ++i) r_ += A_[i] * VertexAt(i).Parameters();
  }
  void ComputeJacobians() override {}
  std::string TypeInfo() const override { return "LinearEdge"; }

 private:
  const Vertex& VertexAt(size_t i) const { return *vertices_[i]; }
  std::vector<MatXX> A_;
  VecX z_, r_;
  MatXX W_;
};

/// Four frames with IMU, twelve landmarks hosted in the first two, a prior on frame 0: a window in miniature.
struct SmallWindow {
  Graph graph;
  std::vector<std::shared_ptr<VertexPose>> poses;
  std::vector<std::shared_ptr<VertexSpeedBias>> speed_biases;
  std::vector<std::shared_ptr<VertexInverseDepth>> landmarks;
  std::shared_ptr<VertexPose> extrinsic;

  explicit SmallWindow(uint64_t seed = 1, int frames = 4) {
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

  /// Frame 0 and the landmarks it hosts, and all edges at them.
  std::vector<std::shared_ptr<Vertex>> Oldest() const {
    std::vector<std::shared_ptr<Vertex>> drop{poses[0], speed_biases[0]};
    for (size_t l = 0; l < landmarks.size(); l += 2) drop.push_back(landmarks[l]);
    return drop;
  }
  std::vector<std::shared_ptr<Edge>> EdgesAt(const std::vector<std::shared_ptr<Vertex>>& vertices) const {
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
};

/// The oracle: H and b of the edges over `order` (then everything else is assumed fixed), built block by block with
/// plain dense products, then one Schur complement of the last variables.
inline void DenseNormalEquations(const std::vector<std::shared_ptr<Edge>>& edges,
                                 const std::vector<std::shared_ptr<Vertex>>& order, MatXX* H, VecX* b) {
  std::map<const Vertex*, int> row;
  int n = 0;
  for (const auto& v : order) {
    row[v.get()] = n;
    n += v->LocalDimension();
  }
  *H = MatXX::Zero(n, n);
  *b = VecX::Zero(n);
  for (const auto& edge : edges) {
    edge->ComputeResidual();
    edge->ComputeJacobians();
    MatXX J = MatXX::Zero(edge->ResidualDimension(), n);
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      const Vertex& v = *edge->Vertices()[i];
      if (row.count(&v)) J.middleCols(row[&v], v.LocalDimension()) = edge->Jacobian(i);
    }
    double drho;
    MatXX W;
    edge->RobustInfo(&drho, &W);
    *H += J.transpose() * W * J;
    *b -= drho * J.transpose() * edge->Information() * edge->Residual();
  }
}

}  // namespace ch5
