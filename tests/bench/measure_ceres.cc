#include "ch5_backend/experiments/studies/homework/graded_priors.h"
#include "tests/bench/measure.h"

namespace ch5::bench {
namespace {

// Which algorithm serves Ceres better differs from graph to graph: the one that ended sooner counts.
peer::PeerResult SolvePoseGraph(const Problem& problem) {
  peer::PeerOptions options = problem.options;
  options.dogleg = true;
  const peer::PeerResult dogleg = peer::SolvePoseGraphWithCeres(problem.pose_graph, options);
  options.dogleg = false;
  const peer::PeerResult levenberg = peer::SolvePoseGraphWithCeres(problem.pose_graph, options);
  return dogleg.seconds < levenberg.seconds ? dogleg : levenberg;
}

// VINS-Mono's own way, with two eigendecompositions of dense matrices; Ceres has none.
peer::PeerResult MarginalizeOldest(const Problem& problem) {
  const WindowGraph window = BuildWindowGraph(problem.window);
  const DropSet oldest = OldestFrameOf(problem.window, window);
  return Timed([&] { return PriorByMarginalizationInfo(oldest.edges, oldest.vertices)->GetPrior().J.squaredNorm(); });
}

}  // namespace

peer::PeerResult Solve(const Problem& problem) {
  if (problem.task == Problem::Task::kMarginalize) return MarginalizeOldest(problem);
  if (problem.task == Problem::Task::kCovariance) {
    return problem.kind == Problem::Kind::kWindow
               ? peer::WindowCovariancesWithCeres(problem.window, problem.options)
               : peer::PoseGraphCovariancesWithCeres(problem.pose_graph, problem.options);
  }
  switch (problem.kind) {
    case Problem::Kind::kWindow: return peer::SolveWindowWithCeres(problem.window, problem.options);
    case Problem::Kind::kPoseGraph: return SolvePoseGraph(problem);
    case Problem::Kind::kBal: break;
  }
  return peer::SolveBalWithCeres(problem.bal, problem.options);
}

}  // namespace ch5::bench
