// Time of the dense and the sparse solver on the course's scene, and of the sparse one on problems of "Bundle Adjustment in the Large".
// The course's original takes 533 ms for 30 frames × 1000 points (LM, two poses fixed, at most 5 iterations); the
// dense solver, on plain Eigen, is to take at most a third of it, 178 ms: tests/bench/bench_solve --benchmark_filter=DenseSolver.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <fstream>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/files/bal.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/sparse/sparse_optimizer.h"

namespace ch5 {
namespace {

// Remembers all states of a graph, so that each repetition starts alike.
class StartingPoint {
 public:
  explicit StartingPoint(Graph* graph) : graph_(graph) {
    for (const auto& vertex : graph->Vertices()) states_.push_back(vertex->Parameters());
  }
  void Restore() {
    for (size_t i = 0; i < states_.size(); ++i) graph_->Vertices()[i]->Parameters() = states_[i];
  }

 private:
  Graph* graph_;
  std::vector<VecX> states_;
};

template <typename Solve>
void Repeat(benchmark::State& state, Graph* graph, const Solve& solve) {
  StartingPoint start(graph);
  Summary summary;
  double seconds = 0.0;
  int iterations = 0;
  for (auto _ : state) {
    start.Restore();
    summary = solve();
    state.SetIterationTime(summary.seconds);
    seconds += summary.seconds;
    iterations += summary.iterations;
  }
  state.counters["ms_per_iteration"] = 1e3 * seconds / iterations;
  state.counters["iterations"] = summary.iterations;
  state.counters["cost"] = summary.final_cost;
}

void MakeCourseScene(int frames, int points, MonoBa* scene) {
  MonoBaOptions options;
  options.frames = frames;
  options.points = points;
  BuildMonoBa(SimulateMonoBa(options), Gauge::kFixTwoFrames, 1.0, 0.0, scene);
}

SolveOptions FiveIterations() {
  SolveOptions options;
  options.max_iterations = 5;
  return options;
}

void DenseSolver(benchmark::State& state) {
  MonoBa scene;
  MakeCourseScene(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), &scene);
  Problem problem(&scene.graph);
  Repeat(state, &scene.graph, [&] { return problem.Solve(FiveIterations()); });
}
BENCHMARK(DenseSolver)
    ->ArgNames({"frames", "points"})
    ->Args({3, 20})
    ->Args({10, 200})
    ->Args({30, 200})
    ->Args({30, 1000})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

void SparseSolver(benchmark::State& state) {
  MonoBa scene;
  MakeCourseScene(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), &scene);
  SparseOptimizer optimizer(&scene.graph, static_cast<int>(state.range(2)));
  Repeat(state, &scene.graph, [&] { return optimizer.Solve(FiveIterations()); });
}
BENCHMARK(SparseSolver)
    ->ArgNames({"frames", "points", "threads"})
    ->ArgsProduct({{3}, {20}, {1}})
    ->ArgsProduct({{10}, {200}, {1, 2}})
    ->ArgsProduct({{30}, {1000, 4000}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

void Bal(benchmark::State& state, const char* name) {
  const std::string path = std::string(CH5_DATA_DIR) + "/bal/" + name;
  if (!std::ifstream(path)) return state.SkipWithError(("no file " + path).c_str());
  BalGraph problem;
  BuildBal(ReadBal(path), nullptr, &problem);
  SparseOptimizer optimizer(&problem.graph, static_cast<int>(state.range(0)));
  optimizer.SetDamping(Damping::kDiagonal);
  SolveOptions options;
  options.max_iterations = 20;
  options.tau = 1e-4;
  options.cost_tolerance = options.gradient_tolerance = options.step_tolerance = 0.0;
  Repeat(state, &problem.graph, [&] { return optimizer.Solve(options); });
}
BENCHMARK_CAPTURE(Bal, 49_7776, "problem-49-7776-pre.txt")
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Bal, 16_22106, "problem-16-22106-pre.txt")
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ch5

BENCHMARK_MAIN();
