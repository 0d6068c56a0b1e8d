#pragma once
// Points seen by poses in a row, each by three neighbors: S is sparse, H has a unique minimum.
#include <algorithm>
#include <memory>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5::test {

struct Bundle {
  Graph graph;
  std::vector<std::shared_ptr<VertexPose>> poses;  // the first two are fixed
  std::vector<std::shared_ptr<VertexPointXYZ>> points;
  std::vector<std::shared_ptr<Edge>> edges;
  std::vector<VecX> truth;  // the parameters of poses, then points

  static constexpr double kSigma = 1e-3;

  /// @param noise  of the pixels, in σ;  `start` is how far poses and points begin from the truth
  /// @param shuffled  the same members under the same ids, added in another order
  explicit Bundle(int num_poses, int num_points, double noise = 1.0, double start = 0.02, bool shuffled = false) {
    Random random(21);
    for (int i = 0; i < num_poses; ++i) {
      poses.push_back(std::make_shared<VertexPose>(ExpSO3(NormalVector(&random, 0.1)),
                                                   Vec3(0.5 * i, 0, 0) + NormalVector(&random, 0.1)));
      poses.back()->SetFixed(i < 2);
      truth.push_back(poses.back()->Parameters());
    }
    for (int k = 0; k < num_points; ++k) {
      const int first = k % (num_poses - 2);  // seen by poses first, first + 1, first + 2
      points.push_back(
          std::make_shared<VertexPointXYZ>(Vec3(0.5 * first + random.Uniform(-1, 2), random.Uniform(-2, 2), 6.0)));
      truth.push_back(points.back()->Parameters());
      for (int i = first; i < first + 3; ++i) {
        const Vec3 p_C = poses[i]->q().conjugate() * (points[k]->GetEstimate() - poses[i]->p());
        const Vec2 u = p_C.head<2>() / p_C.z() + noise * kSigma * Vec2(random.Normal(), random.Normal());
        edges.push_back(std::make_shared<EdgeReprojectionXYZ>(points[k], poses[i], u));
        edges.back()->SetInformation(MatXX::Identity(2, 2) / (kSigma * kSigma));
      }
    }
    for (const auto& pose : poses) {
      const Vec3 p = NormalVector(&random, start), theta = NormalVector(&random, start);
      const Vec6 delta = (Vec6() << p, theta).finished();
      if (!pose->IsFixed()) pose->Plus(delta.data());
    }
    for (const auto& point : points) point->Plus(NormalVector(&random, start).data());
    Add(shuffled);
  }

  double DistanceToTruth() const {
    double largest = 0.0;
    for (size_t i = 0; i < truth.size(); ++i) {
      largest = std::max(largest, (graph.Vertices()[i]->Parameters() - truth[i]).cwiseAbs().maxCoeff());
    }
    return largest;
  }

 private:
  void Add(bool shuffled) {
    std::vector<std::shared_ptr<Vertex>> vertices(poses.begin(), poses.end());
    vertices.insert(vertices.end(), points.begin(), points.end());
    Random random(22);
    for (const int i : Order(vertices.size(), shuffled, &random)) graph.AddVertex(vertices[i], i);
    for (const int i : Order(edges.size(), shuffled, &random)) graph.AddEdge(edges[i], i);
  }
  static std::vector<int> Order(size_t size, bool shuffled, Random* random) {
    std::vector<int> order(size);
    for (size_t i = 0; i < size; ++i) order[i] = static_cast<int>(i);
    for (size_t i = size; shuffled && i-- > 1;) {
      std::swap(order[i], order[static_cast<size_t>(random->Uniform() * static_cast<double>(i))]);
    }
    return order;
  }
};

}  // namespace ch5::test
