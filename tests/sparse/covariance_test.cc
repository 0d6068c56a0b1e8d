// Blocks of H⁻¹ by hand; many more, against the dense inverse, are in ../g2o/covariance_conformance_test.cc.
#include "ch5_backend/sparse/covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "ch5_backend/sparse/joint_covariance.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/scenes.h"
#include "tests/sparse/scalar_graph.h"

namespace ch5::test {
namespace {

// H⁻¹ = (2 1; 1 2)/3
TEST(Covariance, OfAPoseAndALandmarkByHand) {
  OnePoseOneLandmark small;
  const Vertex &pose = *small.poses[0], &landmark = *small.landmarks[0];
  for (const CovarianceFactor factor : {CovarianceFactor::kSparse, CovarianceFactor::kDense}) {
    Covariance covariance(&small.graph, {}, factor);
    EXPECT_DOUBLE_EQ(covariance.Block(pose, pose)(0, 0), 2.0 / 3.0);
    EXPECT_DOUBLE_EQ(covariance.Block(pose, landmark)(0, 0), 1.0 / 3.0);
    EXPECT_DOUBLE_EQ(covariance.Block(landmark, landmark)(0, 0), 2.0 / 3.0);
    EXPECT_THROW(covariance.Block(pose, *small.origin), CovarianceError) << "a fixed vertex has none";
  }
  // Held, the pose has no variance, and the landmark that of its two measurements.
  Covariance held(&small.graph, {}, CovarianceFactor::kSparse, 1,
                  {{small.poses[0], [] { return MatXX(MatXX::Ones(1, 1)); }}});
  EXPECT_NEAR(held.Block(pose, pose)(0, 0), 0.0, 1e-15);
  EXPECT_NEAR(held.Block(landmark, landmark)(0, 0), 0.5, 1e-15);
}

// The same H⁻¹ as a whole, whatever the order; increments of several numbers keep together.
TEST(JointCovariance, OfAPoseAndALandmarkByHand) {
  OnePoseOneLandmark small;
  Covariance covariance(&small.graph);
  Mat22 expected;
  expected << 2, 1, 1, 2;
  EXPECT_LT((JointCovariance({small.poses[0], small.landmarks[0]}, &covariance) - expected / 3).norm(), 1e-15);
  EXPECT_LT((JointCovariance({small.landmarks[0], small.poses[0]}, &covariance) - expected / 3).norm(), 1e-15);
  EXPECT_EQ(JointCovariance({}, &covariance).size(), 0);
  EXPECT_THROW(JointCovariance({small.poses[0], small.origin}, &covariance), CovarianceError);
  EXPECT_THROW(JointCovariance({small.poses[0], nullptr}, &covariance), CovarianceError);
}

TEST(JointCovariance, IsTheInverseOfTheHessian) {
  Graph graph;
  AllScenes().front().build(&graph);
  SparseSolver solver(&graph);
  solver.SetOrdering();
  solver.MakeHessian();
  std::vector<std::shared_ptr<Vertex>> vertices;
  for (const auto& vertex : graph.Vertices()) {
    if (vertex->OrderingId() >= 0) vertices.push_back(vertex);
  }
  const auto by_row = [](const auto& a, const auto& b) { return a->OrderingId() > b->OrderingId(); };
  std::sort(vertices.begin(), vertices.end(), by_row);  // the last row first
  const MatXX H_inverse = solver.DenseHessian().inverse();
  Covariance covariance(&graph);
  const MatXX joint = JointCovariance(vertices, &covariance);
  ASSERT_EQ(joint.rows(), H_inverse.rows());
  Eigen::Index row = 0;
  for (const auto& a : vertices) {
    Eigen::Index column = 0;
    for (const auto& b : vertices) {
      const int m = a->LocalDimension(), n = b->LocalDimension();
      const MatXX expected = H_inverse.block(a->OrderingId(), b->OrderingId(), m, n);
      EXPECT_LT((joint.block(row, column, m, n) - expected).norm(), 1e-6 * H_inverse.norm());
      column += n;
    }
    row += a->LocalDimension();
  }
}

}  // namespace
}  // namespace ch5::test
