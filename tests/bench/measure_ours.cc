#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/window/policy.h"
#include "tests/bench/measure.h"
#include "tests/bench/process.h"

namespace ch5::bench {
namespace {

// @param tau, landmark_steps, rescue_steps  what serves unless the options say otherwise
peer::PeerResult Run(Graph* graph, const peer::PeerOptions& options, double tau, int landmark_steps,
                     int rescue_steps = 0) {
  SparseOptimizer optimizer(graph, options.threads);
  SolveOptions solve;
  solve.max_iterations = options.iterations;
  solve.cost_tolerance = options.tolerance;
  solve.gradient_tolerance = solve.step_tolerance = 0.0;
  solve.landmark_steps = options.inner ? (*options.inner ? VinsOptions().landmark_steps : 0) : landmark_steps;
  solve.rescue_steps = options.inner.value_or(true) ? rescue_steps : 0;
  optimizer.SetDamping(Damping::kDiagonal);
  solve.tau = options.radius ? 1.0 / *options.radius : tau;
  solve.initial_radius = options.radius.value_or(solve.initial_radius);
  if (options.dogleg) solve.algorithm = Algorithm::kDogleg;
  peer::PeerResult result;
  result.bytes_before = MemoryBytes("VmRSS:");
  const Stopwatch watch(options.wall);
  solve.callback = [&](const IterationInfo& info) {
    result.trace.push_back({watch.Seconds(), info.cost});
    return true;
  };
  const Summary summary = optimizer.Solve(solve);
  result.seconds = watch.Seconds();
  result.initial_cost = summary.initial_cost;
  result.final_cost = summary.final_cost;
  result.trials = summary.cost_evaluations;
  return result;
}

peer::PeerResult MarginalizeOldest(const WindowGraph& window, const Problem& problem) {
  const DropSet oldest = OldestFrameOf(problem.window, window);
  return Timed(problem.options.wall, [&] { return Marginalize(oldest.edges, oldest.vertices).J.squaredNorm(); });
}

peer::PeerResult PoseCovariances(Graph* graph, const Problem& problem) {
  std::vector<VertexPair> pairs;
  for (const auto& vertex : graph->Vertices()) {
    if (dynamic_cast<VertexPose*>(vertex.get()) && !vertex->IsFixed()) pairs.emplace_back(vertex, vertex);
  }
  return Timed(problem.options.wall, [&] {
    double sum = 0.0;
    for (const MatXX& block : Covariance(graph, {}, CovarianceFactor::kSparse, problem.options.threads).Blocks(pairs))
      sum += block.trace();
    return sum;
  });
}

}  // namespace

peer::PeerResult Solve(const Problem& problem) {
  if (problem.kind == Problem::Kind::kWindow) {
    WindowGraph window = BuildWindowGraph(problem.window);
    if (problem.task == Problem::Task::kMarginalize) return MarginalizeOldest(window, problem);
    if (problem.task == Problem::Task::kCovariance) return PoseCovariances(&window.graph, problem);
    // As the estimators take them.
    const int landmark_steps = problem.window.imu.empty() ? 0 : VinsOptions().landmark_steps;
    return Run(&window.graph, problem.options, SolveOptions().tau, landmark_steps);
  }
  if (problem.kind == Problem::Kind::kPoseGraph) {
    G2oFile file = ReadG2o(problem.pose_graph);
    FixFreeParts(file.graph);
    if (problem.task == Problem::Task::kCovariance) return PoseCovariances(&file.graph, problem);
    return Run(&file.graph, problem.options, SolveOptions().tau, 0);
  }
  BalGraph bal =
      problem.options.points ? BuildBal(problem.bal, nullptr, *problem.options.points) : BuildBal(problem.bal, nullptr);
  return Run(&bal.graph, problem.options, bal.tau, 0, bal.rescue_steps);
}

}  // namespace ch5::bench
