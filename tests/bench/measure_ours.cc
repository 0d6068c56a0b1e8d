#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "tests/bench/measure.h"
#include "tests/bench/memory.h"

namespace ch5::bench {
namespace {

peer::PeerResult Run(Graph* graph, const Problem& problem, double tau = SolveOptions().tau) {
  const peer::PeerOptions& options = problem.options;
  SparseOptimizer optimizer(graph, options.threads);
  SolveOptions solve;
  solve.max_iterations = options.iterations;
  solve.cost_tolerance = options.tolerance;
  solve.gradient_tolerance = solve.step_tolerance = 0.0;
  solve.landmark_steps = problem.landmark_steps;
  optimizer.SetDamping(Damping::kDiagonal);
  solve.tau = tau;
  if (options.dogleg) solve.algorithm = Algorithm::kDogleg;
  const double bytes_before = MemoryBytes("VmRSS:");
  const Summary summary = optimizer.Solve(solve);
  peer::PeerResult result{summary.initial_cost, summary.final_cost, summary.seconds, summary.cost_evaluations, {},
                          bytes_before};
  for (const IterationInfo& info : summary.trace) result.trace.push_back({info.seconds, info.cost});
  return result;
}

peer::PeerResult MarginalizeOldest(const WindowGraph& window, const Problem& problem) {
  const DropSet oldest = OldestFrameOf(problem.window, window);
  return Timed([&] { return Marginalize(oldest.edges, oldest.vertices).J.squaredNorm(); });
}

peer::PeerResult PoseCovariances(Graph* graph, const Problem& problem) {
  std::vector<VertexPair> pairs;
  for (const auto& vertex : graph->Vertices()) {
    if (dynamic_cast<VertexPose*>(vertex.get()) && !vertex->IsFixed()) pairs.emplace_back(vertex, vertex);
  }
  return Timed([&] {
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
    return Run(&window.graph, problem);
  }
  if (problem.kind == Problem::Kind::kPoseGraph) {
    G2oFile file = ReadG2o(problem.pose_graph);
    FixFreeParts(file.graph);
    if (problem.task == Problem::Task::kCovariance) return PoseCovariances(&file.graph, problem);
    return Run(&file.graph, problem);
  }
  BalGraph bal = BuildBal(problem.bal, nullptr);
  return Run(&bal.graph, problem, bal.tau);
}

}  // namespace ch5::bench
