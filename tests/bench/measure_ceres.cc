#include "tests/bench/measure.h"

ch5::peer::PeerResult ch5::bench::Solve(const Problem& problem) {
  switch (problem.kind) {
    case Problem::Kind::kWindow: return peer::SolveWindowWithCeres(problem.window, problem.options);
    case Problem::Kind::kPoseGraph: return peer::SolvePoseGraphWithCeres(problem.pose_graph, problem.options);
    case Problem::Kind::kBal: break;
  }
  return peer::SolveBalWithCeres(problem.bal, problem.options);
}
