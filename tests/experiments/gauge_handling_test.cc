#include "ch5_backend/experiments/studies/gauge/gauge_handling.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "ch5_backend/experiments/studies/gauge/gauge_solve.h"
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

TEST(GaugeHandling, FixationKeepsPositionAndYawOfTheFirstPoseWhileTheRestOfItMoves) {
  const GaugeSolution fixed = SolveForCovariance(SceneOf(5, 20), GaugeHandling::kFixation);
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
  const double cost = SolveForCovariance(SceneOf(5, 20), GaugeHandling::kFixation).summary.final_cost;
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
  GaugeSolution free = SolveForCovariance(SceneOf(10, 60), GaugeHandling::kFree);
  SparseSolver solver(&free.problem.graph);
  solver.Hold(free.held);
  solver.SetOrdering();
  solver.MakeHessian();
  const MatXX H = solver.DenseHessian();
  const VecX eigenvalues = Eigen::SelfAdjointEigenSolver<MatXX>(H, Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = eigenvalues.maxCoeff();
  EXPECT_LT(eigenvalues[3], 1e-12 * largest);
  EXPECT_GT(eigenvalues[4], 1e4 * std::abs(eigenvalues[3])) << "a clear gap";
  const MatXX U = GaugeNullSpace(free.vertices, GaugeGroup::kVisualInertial);
  const std::vector<int> rows = RowsInHessian(free.vertices);
  EXPECT_LT((MatXX(H(rows, rows)) * U).norm(), 1e-11 * largest * U.norm());
}

TEST(GaugeHandling, SparseMarginalsAreThoseOfTheDenseCovariance) {
  GaugeSolution fixed = SolveForCovariance(SceneOf(5, 20), GaugeHandling::kFixation);
  Covariance covariance(&fixed.problem.graph, {}, CovarianceFactor::kSparse, 1, fixed.held);
  const MatXX difference = JointCovariance(fixed.vertices, &covariance) - fixed.covariance;
  EXPECT_LT(difference.norm(), 1e-8 * fixed.covariance.norm());
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
