// The null space of monocular bundle adjustment, the marginalization that keeps it, and what holding a gauge costs.
#include <gtest/gtest.h>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/gauge/gauge_solve.h"
#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"
#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/simulate/mono_ba.h"

namespace ch5 {
namespace {

// Of poses and landmarks in the order of H's rows.
MatXX NullSpaceOf(const MonoBa& ba) {
  Vertices vertices(ba.poses.begin(), ba.poses.end());
  vertices.insert(vertices.end(), ba.landmarks.begin(), ba.landmarks.end());
  return GaugeNullSpace(vertices, GaugeGroup::kMonocular);
}

TEST(Gauge, FreeHessianHasTheSevenKnownNullDirectionsAndNoOther) {
  for (const auto& options : {MonoBaOptions{3, 20}, MonoBaOptions{6, 40}}) {
    const MonoBaScene scene = SimulateMonoBa(options);
    MonoBa ba = BuildMonoBa(scene, Gauge::kFree, 1.0, 0.0);
    Problem problem(&ba.graph);
    const Summary summary = problem.Solve();
    ASSERT_TRUE(IsConverged(summary.termination)) << summary.message;
    problem.MakeHessian();
    const MatXX& H = problem.Hessian();
    EXPECT_EQ(NullDimension(H), 7);
    // Rounding: a sum of up to 80 residuals' products, each exact to 1e-16 of the greatest entry.
    EXPECT_LT((H * NullSpaceOf(ba)).cwiseAbs().maxCoeff(), 1e-12 * H.cwiseAbs().maxCoeff());
    VecX none;
    problem.SolveLinearSystem(/*lambda=*/0.0, &none);
    EXPECT_EQ(NullDimension(problem.SchurComplement()), 7) << "eliminating the landmarks keeps the gauge";
  }
}

TEST(Gauge, PriorsAndFixedFramesLeaveNoNullDirection) {
  const MonoBaScene scene = SimulateMonoBa({3, 20});
  for (const Gauge gauge : {Gauge::kPriorMinimal, Gauge::kPriorTwoFrames, Gauge::kFixTwoFrames}) {
    MonoBa ba = BuildMonoBa(scene, gauge, 1.0, 1.0);
    Problem problem(&ba.graph);
    problem.MakeHessian();
    EXPECT_EQ(NullDimension(problem.Hessian()), 0);
  }
}

// Arc among planes, sums over trials: fixation takes more iterations than the free gauge, also where its first pose has its
// place from the start, so that its way is no longer; but not where little is damped.
TEST(GaugeMethods, FixationTakesMoreIterationsThroughTheDampingAlone) {
  const auto more = [](GaugeHandling free, bool first_pose_in_place, const GaugeSettings& settings) {
    int iterations = 0;
    for (int trial = 0; trial < 20; ++trial) {
      VisualInertialScene scene = SimulateVisualInertial(GaugeConfigurations(trial)[1].options);
      if (first_pose_in_place) {
        Transform& first = scene.initial.front().T_W_B;
        const Transform& truth = scene.truth.front().T_W_B;
        const Vec3 error = LogSO3(first.q * truth.q.conjugate());
        first = {ExpSO3(Vec3(error.x(), error.y(), 0.0)) * truth.q, truth.p};
      }
      iterations += SolveGauge(scene, {GaugeHandling::kFixation}, settings).summary.iterations;
      iterations -= SolveGauge(scene, {free}, settings).summary.iterations;
    }
    return iterations;
  };
  const GaugeSettings usual;
  EXPECT_GE(more(GaugeHandling::kFree, false, usual), 7);
  EXPECT_GE(more(GaugeHandling::kFree, true, usual), 7);
  GaugeSettings tenth, none;
  tenth.solve.tau = 0.1 * usual.solve.tau;
  none.solve.algorithm = Algorithm::kGaussNewton;
  EXPECT_LE(more(GaugeHandling::kFree, false, tenth), 3);
  EXPECT_LE(more(GaugeHandling::kPseudoInverse, false, none), 1);
}

// HW7 and its trap: with the course's own draw of depths, 400 points put some behind the camera.
TEST(MonoBaScene, KeepsEveryInitialDepthPositive) {
  const MonoBaScene scene = SimulateMonoBa({10, 2000});
  for (const double inverse_depth : scene.initial_inverse_depths) {
    EXPECT_GT(inverse_depth, 0.0);
    EXPECT_LT(1.0 / inverse_depth, 8.0 + 3.0);
  }
}

}  // namespace
}  // namespace ch5
