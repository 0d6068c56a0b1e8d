#pragma once
/// A graph small enough to number, order and eliminate by hand: numbers on a line, and distances between them.

#include <memory>
#include <vector>

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5::test {

/// r = (b − a) − d.
class EdgeDistance : public SizedEdge<1, VertexScalar, VertexScalar> {
 public:
  EdgeDistance(std::shared_ptr<VertexScalar> a, std::shared_ptr<VertexScalar> b, double d)
      : SizedEdge(std::move(a), std::move(b)), d_(d) {}
  void ComputeResidual() override { r_ = GetVertex<1>().GetEstimate() - GetVertex<0>().GetEstimate() - Vec1(d_); }
  void ComputeJacobians() override {
    J<0>() << -1.0;
    J<1>() << 1.0;
  }
  std::string TypeInfo() const override { return "EdgeDistance"; }

 private:
  using Vec1 = Eigen::Matrix<double, 1, 1>;
  double d_;
};

/// Vertices at 0: a fixed origin, poses and landmarks.
struct ScalarGraph {
  Graph graph;
  std::shared_ptr<VertexScalar> origin = Add(Role::kPose);
  std::vector<std::shared_ptr<VertexScalar>> poses, landmarks;

  ScalarGraph(int num_poses, int num_landmarks) {
    origin->SetFixed();
    for (int i = 0; i < num_poses; ++i) poses.push_back(Add(Role::kPose));
    for (int l = 0; l < num_landmarks; ++l) landmarks.push_back(Add(Role::kLandmark));
  }
  void Tie(const std::shared_ptr<VertexScalar>& a, const std::shared_ptr<VertexScalar>& b, double d) {
    graph.AddEdge(std::make_shared<EdgeDistance>(a, b, d));
  }

 private:
  std::shared_ptr<VertexScalar> Add(Role role) {
    auto vertex = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
    vertex->SetRole(role);
    graph.AddVertex(vertex);
    return vertex;
  }
};

/// r = x − 1, y − x − 2, y − 5 at x = y = 0:  H = (2 −1; −1 2),  b = (−1, 7).
struct OnePoseOneLandmark : ScalarGraph {
  OnePoseOneLandmark() : ScalarGraph(1, 1) {
    Tie(origin, poses[0], 1.0);
    Tie(poses[0], landmarks[0], 2.0);
    Tie(origin, landmarks[0], 5.0);
  }
};

}  // namespace ch5::test
