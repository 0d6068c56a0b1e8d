#pragma once
/// Small graphs to marginalize in.

#include <gtest/gtest.h>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/graph/graph.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/types/inertial/edge_imu.h"
#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5 {

/// |A − B| / |B|, by Frobenius' norm.
double RelativeError(const MatXX& A, const MatXX& B);

/// Of standard normal entries.
MatXX NormalMatrix(int rows, int columns, Random* random);

/// r = Σ A_i x_i − z, for problems whose batch solution is known exactly.
class LinearEdge : public Edge {
 public:
  LinearEdge(const std::vector<std::shared_ptr<Vertex>>& vertices, std::vector<MatXX> A, const VecX& z);
  void ComputeResidual() override;
  void ComputeJacobians() override {}
  std::string TypeInfo() const override { return "LinearEdge"; }

 private:
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

  explicit SmallWindow(uint64_t seed = 1, int frames = 4);

  /// Frame 0 and the landmarks it hosts, and all edges at them.
  std::vector<std::shared_ptr<Vertex>> Oldest() const;
  std::vector<std::shared_ptr<Edge>> EdgesAt(const std::vector<std::shared_ptr<Vertex>>& vertices) const;
};

struct DenseSystem {
  MatXX H;
  VecX b;
};

/// The oracle: H and b of the edges over `order` and then `dropped`, everything else assumed fixed, built edge by edge
/// with plain dense products.
DenseSystem DenseNormalEquations(const std::vector<std::shared_ptr<Edge>>& edges,
                                 std::vector<std::shared_ptr<Vertex>> order,
                                 const std::vector<std::shared_ptr<Vertex>>& dropped = {});

/// Their Schur complement on the first n variables.
MatXX Schur(const MatXX& H, Eigen::Index n);
VecX SchurB(const MatXX& H, const VecX& b, Eigen::Index n);

}  // namespace ch5
