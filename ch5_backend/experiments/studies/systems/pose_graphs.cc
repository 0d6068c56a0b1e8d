// g2o's data sets: time of an iteration, memory, and the way down.  Kümmerle et al., ICRA 2011, Table I and Fig. 7
#include <sys/resource.h>

#include <stdexcept>

#include "ch5_backend/experiments/studies/pose_graph_study.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/files/g2o_file.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#ifdef CH5_HAS_CHOLMOD
#include "ch5_backend/linear/cholmod/cholmod_solver.h"
#endif

namespace ch5 {
namespace {

struct Run {
  const char* algorithm;
  Algorithm kind;
  const char* solver;
};
constexpr Run kRuns[] = {{"Levenberg-Marquardt", Algorithm::kLevenbergMarquardt, "sparse"},
                         {"Gauss-Newton", Algorithm::kGaussNewton, "sparse"},
                         {"Dogleg", Algorithm::kDogleg, "sparse"},
                         {"Levenberg-Marquardt", Algorithm::kLevenbergMarquardt, "dense"},
                         {"Levenberg-Marquardt", Algorithm::kLevenbergMarquardt, "pcg"},
                         {"Levenberg-Marquardt", Algorithm::kLevenbergMarquardt, "cholmod"}};
constexpr int kNumRuns = sizeof(kRuns) / sizeof(kRuns[0]);
constexpr const char* kFiles[] = {"intel", "MIT", "parking-garage", "sphere2500"};
constexpr int kMostDense = 6000;                    // unknowns
constexpr int kIterations = 100, kForTheTime = 10;  // with our sparse solver, and with others

double PeakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// nullptr if this program has it not.
std::unique_ptr<ReducedSolver> SolverOf(const std::string& name) {
  if (name == "dense") return MakeReducedSolver(ReducedSolverType::kDenseCholesky);
  if (name == "sparse") return MakeReducedSolver(ReducedSolverType::kSparseCholesky);
  if (name == "pcg") return MakeBlockPcg(1e-6);  // g2o's tolerance
#ifdef CH5_HAS_CHOLMOD
  return MakeCholmodSolver();
#else
  return nullptr;
#endif
}

}  // namespace

// A process a run, so that the peak of memory is its own.
CsvTable PoseGraphsTable(int trial, const std::filesystem::path& data) {
  CsvTable table("data_set,poses,edges,unknowns,algorithm,solver,iteration,cost,trials,seconds,megabytes");
  const size_t file = static_cast<size_t>(trial) / kNumRuns;
  if (file >= std::size(kFiles)) throw std::invalid_argument("pose_graphs has no trial " + std::to_string(trial));
  const Run& run = kRuns[trial % kNumRuns];
  G2oFile graph = ReadG2o((data / "posegraph" / (std::string(kFiles[file]) + ".g2o")).string());
  FixFreeParts(graph.graph);
  int unknowns = 0;
  for (const auto& vertex : graph.graph.Vertices()) unknowns += vertex->IsFixed() ? 0 : vertex->LocalDimension();
  std::unique_ptr<ReducedSolver> solver = SolverOf(run.solver);
  if (!solver || (run.solver == std::string("dense") && unknowns > kMostDense)) return table;

  const double before = PeakMegabytes();
  SparseOptimizer optimizer(&graph.graph);
  optimizer.SetReducedSolver(std::move(solver));
  SolveOptions options;
  options.algorithm = run.kind;
  options.max_iterations = run.solver == std::string("sparse") ? kIterations : kForTheTime;
  options.cost_tolerance = 1e-9;
  const Summary summary = optimizer.Solve(options);
  const double megabytes = PeakMegabytes() - before;
  for (const IterationInfo& info : summary.trace) {
    table.Row(kFiles[file], graph.ids.size(), graph.graph.Edges().size(), unknowns, run.algorithm, run.solver,
              info.iteration, info.cost, info.trials, info.seconds, megabytes);
  }
  return table;
}

}  // namespace ch5
