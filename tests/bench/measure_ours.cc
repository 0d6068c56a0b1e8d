#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/experiments/studies/window_graph.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "tests/bench/measure.h"

namespace ch5::bench {
namespace {

peer::PeerResult Run(Graph* graph, const Problem& problem) {
  const peer::PeerOptions& options = problem.options;
  SparseOptimizer optimizer(graph, options.threads);
  SolveOptions solve;
  solve.max_iterations = options.iterations;
  solve.cost_tolerance = options.tolerance;
  solve.gradient_tolerance = solve.step_tolerance = 0.0;
  if (options.dogleg) {
    solve.algorithm = Algorithm::kDogleg;
  } else {
    optimizer.SetDamping(Damping::kDiagonal);
    solve.tau = 1e-4;  // where Ceres begins
  }
  const Summary summary = optimizer.Solve(solve);
  peer::PeerResult result{summary.initial_cost, summary.final_cost, summary.seconds, summary.cost_evaluations, {}};
  for (const IterationInfo& info : summary.trace) result.trace.push_back({info.seconds, info.cost});
  return result;
}

}  // namespace

peer::PeerResult Solve(const Problem& problem) {
  if (problem.kind == Problem::Kind::kWindow) {
    WindowGraph window = BuildWindowGraph(problem.window);
    return Run(&window.graph, problem);
  }
  if (problem.kind == Problem::Kind::kPoseGraph) {
    G2oFile file = ReadG2o(problem.pose_graph);
    FixFreeParts(file.graph);
    return Run(&file.graph, problem);
  }
  BalGraph bal;
  BuildBal(problem.bal, nullptr, &bal);
  return Run(&bal.graph, problem);
}

}  // namespace ch5::bench
