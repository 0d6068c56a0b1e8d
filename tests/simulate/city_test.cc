/// The simulated city: the truth explains the pixels, its solution is as linear as its streets, and the automatic solver
/// comes to it.
#include "ch5_backend/simulate/city.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "ch5_backend/files/bal.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/sparse/sparse_solver.h"

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

Summary SolveCity(ReducedSolverType type, int threads = 1) {
  CityOptions options;
  options.cameras = 420;  // enough for the automatic solver to begin with a power series
  options.points_per_meter = 2.0;
  BalGraph bal = BuildBal(SimulateCity(options).start, nullptr);
  SparseOptimizer optimizer(&bal.graph, threads);
  optimizer.SetDamping(Damping::kDiagonal);
  optimizer.SetReducedSolver(type);
  SolveOptions solve;
  solve.max_iterations = 20;
  return optimizer.Solve(solve);
}

// Streets couple hundreds of cameras weakly: loose steps creep along them, and exact ones do not.
TEST(AutomaticSolver, BeginsWithLooseStepsAndEndsWithExactOnes) {
  const Summary automatic = SolveCity(ReducedSolverType::kAutomatic);
  const Summary loose = SolveCity(ReducedSolverType::kPowerSeries);
  const Summary exact = SolveCity(ReducedSolverType::kSparseCholesky);
  EXPECT_EQ(automatic.trace[1].cost, loose.trace[1].cost);
  EXPECT_LT(automatic.final_cost, 1.002 * exact.final_cost);
  EXPECT_GT(loose.final_cost, 1.01 * exact.final_cost);
  EXPECT_EQ(SolveCity(ReducedSolverType::kAutomatic, 3).final_cost, automatic.final_cost);
}

// Pictures of a place from the internet: pairs of cameras, chosen at random, see five points each. S is nearly
// empty, and its factor nearly full.
TEST(AutomaticSolver, StaysLooseWhereFactoringTakesTooLong) {
  BalProblem problem;
  problem.cameras.assign(410, Vec9::Unit(6));
  Random random(5);
  for (int pair = 0; pair < 2400; ++pair) {
    const int one = static_cast<int>(random.Bits() % 410);
    const int other = (one + 1 + static_cast<int>(random.Bits() % 409)) % 410;
    for (int k = 0; k < 5; ++k) {
      const int point = static_cast<int>(problem.points.size());
      problem.points.push_back(-Vec3::UnitZ());
      problem.observations.push_back({one, point, Vec2::Zero()});
      problem.observations.push_back({other, point, Vec2::Zero()});
    }
  }
  BalGraph bal = BuildBal(problem, nullptr);
  SparseOptimizer optimizer(&bal.graph);
  EXPECT_FALSE(optimizer.GetSolver().SolveExactly());
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
