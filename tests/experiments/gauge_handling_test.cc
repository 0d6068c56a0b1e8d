#include "ch5_backend/experiments/studies/gauge/gauge_handling.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "ch5_backend/experiments/studies/gauge/gauge_solve.h"
#include "ch5_backend/math/psd.h"
#include "ch5_backend/sparse/joint_covariance.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "tests/derivatives.h"

namespace ch5 {
namespace {

VisualInertialScene SceneOf(int keyframes, int points) {
  VisualInertialOptions options;
  options.keyframes = keyframes;
  options.num_points = points;
  return SimulateVisualInertial(options);
}

// The gauge paper's problem, solved to the end with the gauge held, or free.
struct Solved {
  explicit Solved(bool hold_gauge, int keyframes = 5, int points = 20) {
    problem = BuildVisualInertial(SceneOf(keyframes, points));
    held = HoldBiases(problem);
    if (hold_gauge) held.push_back(HoldGauge(problem.first));
    SparseOptimizer optimizer(&problem.graph);
    optimizer.SetDamping(Damping::kDiagonal);
    optimizer.Hold(held);
    SolveOptions tight;
    tight.max_iterations = 100;
    tight.cost_tolerance = tight.gradient_tolerance = 1e-15;
    summary = optimizer.Solve(tight);
    for (const auto& pose : problem.poses) vertices.push_back(pose);
    for (const auto& speed_bias : problem.speed_biases) vertices.push_back(speed_bias);
    for (const auto& point : problem.points) vertices.push_back(point);
  }

  // Σ with rows in the order of `vertices`: H⁻¹ without the held directions.
  MatXX DenseCovariance() {
    SparseSolver solver(&problem.graph);
    solver.Hold(held);
    solver.SetOrdering();
    solver.MakeHessian();
    const MatXX H = solver.DenseHessian();
    // Held directions stand in H as a multiple of the identity: they go out on both sides.
    MatXX keep = MatXX::Identity(H.rows(), H.cols());
    for (const auto& [pose, projection] : solver.HeldPoses()) {
      const int row = solver.GetStructure().pose_offset[pose];
      keep.block(row, row, projection.rows(), projection.cols()) = projection;
    }
    return Reordered(keep * PseudoInversePsd(H, /*nullity=*/0) * keep);
  }

  MatXX Reordered(const MatXX& A) const {
    const int n = TotalLocalDimension(vertices);
    MatXX P = MatXX::Zero(n, n);
    int row = 0;
    for (const auto& vertex : vertices) {
      P.block(row, vertex->OrderingId(), vertex->LocalDimension(), vertex->LocalDimension()).setIdentity();
      row += vertex->LocalDimension();
    }
    return P * A * P.transpose();
  }

  VisualInertialBa problem;
  std::vector<HeldDirections> held;
  Summary summary;
  Vertices vertices;
};

TEST(GaugeHandling, FixationKeepsPositionAndYawOfTheFirstPoseWhileTheRestOfItMoves) {
  Solved fixed(true);
  ASSERT_TRUE(IsConverged(fixed.summary.termination)) << fixed.summary.message;
  const VertexReferencePose& first = *fixed.problem.first;
  EXPECT_EQ((first.p() - first.InitialPosition()).norm(), 0.0);
  EXPECT_LT(std::abs(first.DeltaPhi().z()), 1e-14);
  EXPECT_GT(first.DeltaPhi().head<2>().norm(), 1e-3) << "roll and pitch are observed";
  for (const auto& speed_bias : fixed.problem.speed_biases)
    EXPECT_EQ(speed_bias->b_a().norm() + speed_bias->b_g().norm(), 0.0);
}

// Four constraints for four freedoms cost nothing, and the pseudo-inverse's Gauss-Newton needs no damping.
TEST(GaugeHandling, AllWaysFindTheSameCost) {
  const double cost = Solved(true).summary.final_cost;
  GaugeSettings tight;
  tight.solve.cost_tolerance = 1e-15;
  for (const GaugeMethod& method : {GaugeMethod{GaugeHandling::kFree}, GaugeMethod{GaugeHandling::kPrior, 1e5},
                                    GaugeMethod{GaugeHandling::kPseudoInverse}}) {
    const Summary summary = SolveGauge(SceneOf(5, 20), method, tight).summary;
    EXPECT_TRUE(IsConverged(summary.termination)) << summary.message;
    EXPECT_NEAR(summary.final_cost, cost, 1e-9 * cost) << static_cast<int>(method.handling);
  }
}

TEST(GaugeHandling, TheFreeHessianHasExactlyFourZeroEigenvalues) {
  Solved free(false, 10, 60);
  SparseSolver solver(&free.problem.graph);
  solver.Hold(free.held);
  solver.SetOrdering();
  solver.MakeHessian();
  const VecX eigenvalues =
      Eigen::SelfAdjointEigenSolver<MatXX>(solver.DenseHessian(), Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = eigenvalues.maxCoeff();
  EXPECT_LT(eigenvalues[3], 1e-12 * largest);
  EXPECT_GT(eigenvalues[4], 1e4 * std::abs(eigenvalues[3])) << "a clear gap";
  const MatXX U = GaugeNullSpace(free.vertices, GaugeGroup::kVisualInertial);
  EXPECT_LT((free.Reordered(solver.DenseHessian()) * U).norm(), 1e-11 * largest * U.norm());
}

TEST(GaugeHandling, SparseMarginalsAreThoseOfTheDenseCovariance) {
  Solved fixed(true);
  Covariance covariance(&fixed.problem.graph, {}, CovarianceFactor::kSparse, 1, fixed.held);
  const MatXX dense = fixed.DenseCovariance();
  EXPECT_LT((JointCovariance(fixed.vertices, &covariance) - dense).norm(), 1e-8 * dense.norm());
}

TEST(GaugeHandling, PriorsJacobianIsTheDerivative) {
  auto first = std::make_shared<VertexReferencePose>(ExpSO3({0.3, -0.2, 0.5}), Vec3(1, 2, 3));
  const Vec6 step = (Vec6() << 0.1, -0.2, 0.3, 0.4, -0.3, 0.2).finished();
  first->Plus(step.data());
  EdgeGaugePrior edge(first, 2.0);
  ExpectJacobiansAreDerivatives(&edge);
}

TEST(GaugeHandling, DirectionsThatDoNotHoldTheGaugeAreRefused) {
  EXPECT_THROW(GaugeProjection(MatXX::Identity(6, 2), MatXX::Zero(6, 2)), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
