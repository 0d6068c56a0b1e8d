/// Our fast room against Ceres, taking turns in one process:  race [--threads N] [--repeat N] FILE…
/// FILE is a BAL problem or a window dump (VIOWIN). Built on demand (target race) where Ceres is found.

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>

#include "ch5_backend/apps/studies/window_graph.h"
#include "ch5_backend/solve/sparse_optimizer.h"
#include "tests/bench/ceres_peer.h"

namespace {

using namespace ch5;
using peer::PeerOptions;
using peer::PeerResult;

PeerResult FromSummary(const Summary& summary) {
  PeerResult result{summary.initial_cost, summary.final_cost, summary.seconds, summary.cost_evaluations, {}};
  for (const IterationInfo& info : summary.trace) result.trace.push_back({info.seconds, info.cost});
  return result;
}

PeerResult RunOurs(Graph* graph, const PeerOptions& options) {
  SparseOptimizer optimizer(graph, options.threads);
  SolveOptions solve;
  solve.max_iterations = options.iterations;
  solve.cost_tolerance = options.tolerance;
  solve.gradient_tolerance = solve.step_tolerance = 0.0;
  if (options.dogleg) {
    solve.algorithm = Algorithm::kDogleg;
  } else {
    optimizer.SetDamping(Damping::kDiagonal);
    solve.tau = 1e-4;
  }
  return FromSummary(optimizer.Solve(solve));
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void Compare(const char* what, const std::vector<PeerResult>& ours, const std::vector<PeerResult>& peer,
             const std::function<double(const PeerResult&)>& measure) {
  std::vector<double> a, b, ratios;
  for (size_t k = 0; k < ours.size(); ++k) {
    a.push_back(1e3 * measure(ours[k]));
    b.push_back(1e3 * measure(peer[k]));
    ratios.push_back(b.back() / a.back());
  }
  std::printf("  %-22s %10.2f ms %10.2f ms   ratio %.2f\n", what, Median(a), Median(b), Median(ratios));
}

void Race(const std::string& path, int repeat, int threads) {
  std::string word;
  std::ifstream(path) >> word;
  const bool is_window = word == "VIOWIN";
  const bool has_imu = is_window && path.find("mono") == std::string::npos;
  PeerOptions options;
  options.threads = threads;
  if (is_window) options.tolerance = has_imu ? 0.0 : 1e-6;
  options.dogleg = has_imu;
  if (has_imu) options.iterations = 8;
  BalProblem bal;
  WindowDump dump;
  is_window ? void(dump = ReadWindowDump(path)) : void(bal = ReadBal(path));
  std::vector<PeerResult> ours, peer;
  for (int k = 0; k < repeat; ++k) {
    if (is_window) {
      WindowGraph window = BuildWindowGraph(dump);
      ours.push_back(RunOurs(&window.graph, options));
      peer.push_back(SolveWindowWithCeres(dump, options));
    } else {
      BalGraph graph;
      BuildBal(bal, nullptr, &graph);
      ours.push_back(RunOurs(&graph.graph, options));
      peer.push_back(SolveBalWithCeres(bal, options));
    }
  }
  const PeerResult &a = ours[0], &b = peer[0];
  std::printf("%s, %d threads: cost %.9e / %.9e -> %.9e / %.9e, steps %d / %d\n", path.c_str(), threads, a.initial_cost,
              b.initial_cost, a.final_cost, b.final_cost, a.iterations, b.iterations);
  const double best = std::min(a.final_cost, b.final_cost);
  Compare("total", ours, peer, [](const PeerResult& r) { return r.seconds; });
  Compare("a step", ours, peer, [](const PeerResult& r) { return r.seconds / r.iterations; });
  Compare("to 1 % of the best", ours, peer, [&](const PeerResult& r) { return r.SecondsTo(1.01 * best); });
  Compare("to 0.1 %", ours, peer, [&](const PeerResult& r) { return r.SecondsTo(1.001 * best); });
}

}  // namespace

int main(int argc, char** argv) {
  // BLAS under Ceres is fastest with one thread on matrices this small, and reads this when it is loaded.
  if (!std::getenv("OPENBLAS_NUM_THREADS")) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    execv("/proc/self/exe", argv);
  }
  int threads = 1, repeat = 5;
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--threads") && i + 1 < argc) {
      threads = std::atoi(argv[++i]);
    } else if (!std::strcmp(argv[i], "--repeat") && i + 1 < argc) {
      repeat = std::max(1, std::atoi(argv[++i]));
    } else {
      Race(argv[i], repeat, threads);
    }
  }
}
