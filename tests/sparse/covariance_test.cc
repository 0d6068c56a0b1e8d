// Blocks of H⁻¹ by hand; many more, against the dense inverse, are in ../g2o/covariance_conformance_test.cc.
#include "ch5_backend/sparse/covariance.h"

#include <gtest/gtest.h>

#include "ch5_backend/sparse/joint_covariance.h"
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

// A new vertex may get the address of a removed one, and must not get its numbers.
TEST(Covariance, IsOfTheGraphAsItWas) {
  OnePoseOneLandmark small;
  Covariance covariance(&small.graph);
  const Vertex* landmark = small.landmarks[0].get();
  small.graph.RemoveVertex(small.landmarks[0]);
  small.landmarks.clear();
  std::vector<std::shared_ptr<Vertex>> later;
  for (int k = 0; k < 100; ++k) {
    later.push_back(std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)));
    EXPECT_NE(later.back().get(), landmark);
    EXPECT_THROW(covariance.Block(*small.poses[0], *later.back()), CovarianceError);
  }
  EXPECT_DOUBLE_EQ(covariance.Block(*landmark, *landmark)(0, 0), 2.0 / 3.0);
}

// The same H⁻¹ as a whole, whatever the order.
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

}  // namespace
}  // namespace ch5::test
