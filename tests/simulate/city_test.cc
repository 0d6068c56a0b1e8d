/// The simulated city: the truth explains the pixels, and its solution is as linear as its streets.
#include "ch5_backend/simulate/city.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "ch5_backend/files/bal.h"
#include "ch5_backend/sparse/sparse_optimizer.h"

namespace ch5 {
namespace {

// ½ Σ ‖r‖² of the problem's pixels.
double CostOf(const BalProblem& problem) {
  BalGraph bal = BuildBal(problem, nullptr);
  return Cost(bal.graph);
}

TEST(City, TruthLeavesTheNoiseOfThePixels) {
  CityOptions options;
  options.cameras = 80;
  const City city = SimulateCity(options);
  BalProblem truth = city.start;
  truth.cameras = city.cameras;
  truth.points = city.points;
  const double n = 2.0 * static_cast<double>(truth.observations.size()),
               variance = options.pixel_sigma * options.pixel_sigma;
  EXPECT_NEAR(CostOf(truth), 0.5 * n * variance, 4.0 * std::sqrt(0.5 * n) * variance);
  EXPECT_GT(CostOf(city.start), 10.0 * CostOf(truth));
}

TEST(City, EachCameraSeesHundredsAndEachPointHasViews) {
  CityOptions options;
  options.cameras = 400;  // n = 2: 180 steps along the streets, then 220 across them
  const City city = SimulateCity(options);
  std::vector<std::set<int>> views(city.points.size());
  std::vector<int> seen(city.cameras.size(), 0);
  for (const BalObservation& o : city.start.observations) {
    EXPECT_TRUE(views[static_cast<size_t>(o.point)].insert(o.camera).second) << "seen twice";
    ++seen[static_cast<size_t>(o.camera)];
    EXPECT_LT(o.pixel.norm(), 800.0);
  }
  int loops = 0;  // points that both drives have seen
  for (const auto& cameras : views) {
    EXPECT_GE(cameras.size(), 3u);
    loops += *cameras.begin() < 180 && *cameras.rbegin() >= 180;
  }
  EXPECT_GT(loops, 100);
  const double mean = static_cast<double>(city.start.observations.size()) / options.cameras;
  EXPECT_GT(mean, 300.0);
  EXPECT_LT(mean, 700.0);
}

// Both kinds of reduced solver come to the noise that the unknowns leave: ½ σ² (2m − n) on average.
TEST(City, IsSolved) {
  CityOptions options;
  options.cameras = 40;
  const City city = SimulateCity(options);
  const double m = 2.0 * static_cast<double>(city.start.observations.size());
  const double n = 9.0 * static_cast<double>(city.cameras.size()) + 3.0 * static_cast<double>(city.points.size());
  const double expected = 0.5 * options.pixel_sigma * options.pixel_sigma * (m - n);
  double costs[2];
  for (const bool implicit : {false, true}) {
    BalGraph bal = BuildBal(city.start, nullptr);
    SparseOptimizer optimizer(&bal.graph);
    optimizer.SetDamping(Damping::kDiagonal);
    if (implicit) optimizer.SetReducedSolver(ReducedSolverType::kImplicitPcg, {1e-6, 0.0, 500, 0, {}});
    SolveOptions solve;
    solve.max_iterations = 30;
    solve.tau = 1e-4;
    costs[implicit] = optimizer.Solve(solve).final_cost;
  }
  EXPECT_NEAR(costs[0] / expected, 1.0, 0.05);
  EXPECT_NEAR(costs[1] / costs[0], 1.0, 1e-3);
}

TEST(City, RefusesOptionsOutOfRange) {
  CityOptions options;
  options.cameras = 1;
  EXPECT_THROW(SimulateCity(options), std::invalid_argument);
  options = {};
  options.pixel_sigma = -1.0;
  EXPECT_THROW(SimulateCity(options), std::invalid_argument);
  options = {};
  options.points_per_meter = 0.0;
  EXPECT_THROW(SimulateCity(options), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
