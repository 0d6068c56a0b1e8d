#pragma once
// Points that are poses, each held to the next: the smallest graph with an inside.
#include <memory>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5::test {

// r = b − a − d.
class PointDifference : public SizedEdge<3, VertexPointXYZ, VertexPointXYZ> {
 public:
  PointDifference(std::shared_ptr<VertexPointXYZ> a, std::shared_ptr<VertexPointXYZ> b, const Vec3& d)
      : SizedEdge(std::move(a), std::move(b)), d_(d) {}
  void ComputeResidual() override { r_ = GetVertex<1>().GetEstimate() - GetVertex<0>().GetEstimate() - d_; }
  void ComputeJacobians() override {
    J<0>() = -Mat33::Identity();
    J<1>() = Mat33::Identity();
  }
  std::string TypeInfo() const override { return "PointDifference"; }

 private:
  Vec3 d_;
};

// The point in the pose's own coordinates,  r = Rᵀ(x − p) − z.
class PoseSeesPoint : public SizedEdge<3, VertexPose, VertexPointXYZ> {
 public:
  PoseSeesPoint(std::shared_ptr<VertexPose> pose, std::shared_ptr<VertexPointXYZ> point, const Vec3& z = Vec3::Zero())
      : SizedEdge(std::move(pose), std::move(point)), z_(z) {}
  void ComputeResidual() override {
    r_ = GetVertex<0>().q().conjugate() * (GetVertex<1>().GetEstimate() - GetVertex<0>().p()) - z_;
  }
  std::string TypeInfo() const override { return "PoseSeesPoint"; }

 private:
  Vec3 z_;
};

struct PointChain {
  Graph graph;
  std::vector<std::shared_ptr<VertexPointXYZ>> points;
  std::vector<std::shared_ptr<Edge>> edges;

  explicit PointChain(int num_points) {
    for (int i = 0; i < num_points; ++i) {
      points.push_back(std::make_shared<VertexPointXYZ>(i == 0 ? Vec3(0, 0, 0) : Vec3(1.1 * i, 0.3, -0.2)));
      points.back()->SetRole(Role::kPose);
      graph.AddVertex(points.back());
      if (i == 0) continue;
      edges.push_back(std::make_shared<PointDifference>(points[i - 1], points[i], Vec3(1, 0, 0)));
      graph.AddEdge(edges.back());
    }
  }
};

}  // namespace ch5::test
