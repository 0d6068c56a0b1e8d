// Stage 3: the priors of the first two frames, and what their weight does to the answer.
#include <gtest/gtest.h>

#include "ch5_backend/experiments/studies/prior_study.h"
#include "ch5_backend/types/edge_se3_prior.h"

namespace ch5 {
namespace {

std::vector<std::shared_ptr<Edge>> Priors(const MonoBa& ba) {
  std::vector<std::shared_ptr<Edge>> priors;
  for (const auto& edge : ba.graph.Edges()) {
    if (dynamic_cast<const EdgeSE3Prior*>(edge.get())) priors.push_back(edge);
  }
  return priors;
}

PriorVariant Variant(const std::string& name) {
  for (const PriorVariant& variant : PriorVariants()) {
    if (variant.name == name) return variant;
  }
  throw std::invalid_argument("no variant " + name);
}

PriorRun Solve(const PriorVariant& variant, double weight) {
  return RunPrior(variant, SimulateMonoBa(variant.scene), weight, TightOptions());
}

TEST(PriorEdges, OfTheMinimalGaugeAreSevenConstraints) {
  MonoBa ba = BuildMonoBa(SimulateMonoBa(MonoBaOptions()), Gauge::kPriorMinimal, 1.0, 7.0);
  const auto priors = Priors(ba);
  ASSERT_EQ(priors.size(), 2u);
  EXPECT_EQ(priors[0]->Information(), 7.0 * MatXX::Identity(6, 6));
  const MatXX one = priors[1]->Information();
  EXPECT_NEAR(one.trace(), 7.0, 1e-14);
  EXPECT_LT((one * one - 7.0 * one).norm(), 1e-13) << "7 times a projection on one direction";
}

// Seven constraints can all be met: the optimum is the free one, moved. The solver stops where a step gains less than
// 1e-12 of the cost, and near an optimum the cost's error is quadratic in the state's: 1e-9 leaves room for both.
TEST(MinimalGauge, OptimumsReprojectionCostDoesNotDependOnTheWeight) {
  const PriorVariant variant = Variant("minimal");
  const PriorRun free = Solve(variant, 0.0);
  ASSERT_TRUE(IsConverged(free.summary.termination));
  for (const double weight : {1e2, 1e4, 1e6, 1e8, 1e10}) {
    const PriorRun run = Solve(variant, weight);
    EXPECT_TRUE(IsConverged(run.summary.termination)) << weight;
    EXPECT_NEAR(run.reprojection_cost / free.reprojection_cost, 1.0, 1e-9) << weight;
    EXPECT_LT(run.prior_cost, 1e-9 * free.reprojection_cost) << weight;
    // The errors are linear in the state's error: the square root of the cost's tolerance.
    EXPECT_NEAR(run.rmse.position / free.rmse.position, 1.0, 1e-5) << weight;
    EXPECT_LT(run.drift_position, 1e-6) << weight;
    EXPECT_LT(run.drift_rotation, 1e-6) << weight;
  }
}

// Twelve constraints on seven free directions bend the reconstruction: more weight, more reprojection cost.
TEST(PriorOnTwoFrames, OptimumsReprojectionCostRisesWithTheWeight) {
  const PriorVariant variant = Variant("perturbed");
  double previous = Solve(variant, 0.0).reprojection_cost;
  const double free = previous;
  for (const double weight : {1e4, 1e5, 1e6, 1e7, 1e8, 1e9}) {
    const double cost = Solve(variant, weight).reprojection_cost;
    EXPECT_GT(cost, previous) << weight;
    previous = cost;
  }
  EXPECT_GT(previous, 1.1 * free);
}

// At great weights the observations pull with a constant force against a spring of stiffness w: the drift is c/w.
TEST(PriorOnTwoFrames, DriftVanishesAsOneOverTheWeight) {
  const PriorVariant variant = Variant("perturbed");
  PriorRun previous = Solve(variant, 1e8);
  for (const double weight : {1e9, 1e10, 1e11}) {
    const PriorRun run = Solve(variant, weight);
    EXPECT_NEAR(run.drift_position / previous.drift_position, 0.1, 0.01) << weight;
    EXPECT_NEAR(run.drift_rotation / previous.drift_rotation, 0.1, 0.01) << weight;
    previous = run;
  }
  EXPECT_LT(previous.drift_position, 1e-8);
}

TEST(PriorOnTwoFrames, OfHugeWeightAgreesWithTwoFixedFrames) {
  const PriorVariant variant = Variant("course");  // starts at the truth, where the frames are fixed
  const MonoBaScene scene = SimulateMonoBa(variant.scene);
  const auto solve = [&](Gauge gauge, double weight) {
    MonoBa ba = BuildMonoBa(scene, gauge, variant.pixel_information, weight);
    Problem problem(&ba.graph);
    problem.SetDamping(Damping::kDiagonal);
    EXPECT_TRUE(IsConverged(problem.Solve(TightOptions()).termination));
    return EstimateOf(scene, ba);
  };
  const Rmse difference = Compare(solve(Gauge::kPriorTwoFrames, 1e8), solve(Gauge::kFixTwoFrames, 0.0));
  // The drift is c/w; c ≈ 5e-2 here (force of the observations with W = I), and points lie a few meters away.
  EXPECT_LT(difference.position, 1e-8);
  EXPECT_LT(difference.rotation, 1e-8);
  EXPECT_LT(difference.point, 1e-7);
}

// λ₀ = τ max diag(H) with identity damping: the course's rising curve. λ falls to a third an iteration, so a weight
// a thousand times greater costs log₃ 1000 ≈ 6.3 more.
TEST(Damping, OfTheIdentityMakesIterationsGrowWithTheWeight) {
  PriorVariant variant = Variant("course");
  EXPECT_NEAR(Solve(variant, 1e10).summary.trace[1].lambda / Solve(variant, 1e7).summary.trace[1].lambda, 1e3, 0.1);
  const int more = Solve(variant, 1e10).summary.iterations - Solve(variant, 1e7).summary.iterations;
  EXPECT_GE(more, 5);
  EXPECT_LE(more, 7);
  variant.damping = Damping::kDiagonal;
  EXPECT_NEAR(Solve(variant, 1e10).summary.iterations, Solve(variant, 1e7).summary.iterations, 1);
}

}  // namespace
}  // namespace ch5
