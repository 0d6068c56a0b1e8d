#include "tests/bench/ceres_solve.h"

#include <stdexcept>

#include "tests/bench/process.h"

namespace ch5::peer {
namespace {

ceres::LinearSolverType Type(LinearSolver solver) {
  switch (solver) {
    case LinearSolver::kSparseSchur: return ceres::SPARSE_SCHUR;
    case LinearSolver::kIterativeSchur: return ceres::ITERATIVE_SCHUR;
    case LinearSolver::kSparseNormal: return ceres::SPARSE_NORMAL_CHOLESKY;
    case LinearSolver::kDenseSchur: break;
  }
  return ceres::DENSE_SCHUR;
}

// Ceres' own times are the clock's.
class Recorder : public ceres::IterationCallback {
 public:
  explicit Recorder(const bench::Stopwatch& watch) : watch_(watch) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& it) override {
    if (it.iteration == 0 || it.step_is_successful) cost_ = it.cost;
    trace.push_back({watch_.Seconds(), cost_});
    return ceres::SOLVER_CONTINUE;
  }
  std::vector<PeerPoint> trace;

 private:
  const bench::Stopwatch& watch_;
  double cost_ = 0.0;
};

// A trial that meets the tolerance ends the solve before Ceres counts its iteration.
int Trials(const ceres::Solver::Summary& summary, bool dogleg) {
  const bool last = summary.message.rfind("Function tolerance reached", 0) == 0;
  const int trials = static_cast<int>(summary.iterations.size()) - 1 + (last ? 1 : 0);
  if (!dogleg && trials != summary.num_linear_solves) {  // Dogleg tries shorter steps of the same solution
    throw std::runtime_error("counted " + std::to_string(trials) + " trials where Ceres solved " +
                             std::to_string(summary.num_linear_solves) + " linear systems: " + summary.message);
  }
  return trials;
}

}  // namespace

PeerResult SolveWithCeres(const PeerOptions& options, std::shared_ptr<ceres::ParameterBlockOrdering> ordering,
                          ceres::Problem* problem) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = Type(options.linear_solver);
  ceres_options.linear_solver_ordering = ordering;
  ceres_options.preconditioner_type = ceres::SCHUR_JACOBI;
  ceres_options.dense_linear_algebra_library_type = ceres::LAPACK;
  ceres_options.sparse_linear_algebra_library_type = options.eigen ? ceres::EIGEN_SPARSE : ceres::SUITE_SPARSE;
  ceres_options.trust_region_strategy_type = options.dogleg ? ceres::DOGLEG : ceres::LEVENBERG_MARQUARDT;
  ceres_options.initial_trust_region_radius = options.radius.value_or(ceres_options.initial_trust_region_radius);
  ceres_options.jacobi_scaling = options.scaled;
  ceres_options.use_mixed_precision_solves = options.mixed;
  ceres_options.max_num_refinement_iterations = options.mixed ? 3 : 0;
  if (options.inner.value_or(false) && ordering) {
    ceres_options.use_inner_iterations = true;
    ceres_options.inner_iteration_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (double* landmark : ordering->group_to_elements().begin()->second)
      ceres_options.inner_iteration_ordering->AddElementToGroup(landmark, 0);
  }
  ceres_options.num_threads = options.threads;
  ceres_options.max_num_iterations = options.iterations;
  ceres_options.function_tolerance = options.tolerance;
  ceres_options.gradient_tolerance = ceres_options.parameter_tolerance = 0.0;
  ceres_options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  PeerResult result;
  result.bytes_before = bench::MemoryBytes("VmRSS:");
  const bench::Stopwatch watch(options.wall);
  Recorder recorder(watch);
  ceres_options.callbacks = {&recorder};
  ceres::Solve(ceres_options, problem, &summary);
  result.seconds = watch.Seconds();
  if (!summary.IsSolutionUsable()) throw std::runtime_error("Ceres: " + summary.message);
  result.initial_cost = summary.initial_cost;
  result.final_cost = summary.final_cost;
  result.trials = Trials(summary, options.dogleg);
  result.trace = std::move(recorder.trace);
  return result;
}

PeerResult CovariancesWithCeres(const PeerOptions& options, const std::vector<const double*>& poses,
                                ceres::Problem* problem) {
  ceres::Covariance::Options ceres_options;
  ceres_options.algorithm_type = ceres::SPARSE_QR;
  ceres_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  ceres_options.num_threads = options.threads;
  std::vector<std::pair<const double*, const double*>> blocks;
  for (const double* pose : poses) blocks.emplace_back(pose, pose);
  const bench::Stopwatch watch(options.wall);
  ceres::Covariance covariance(ceres_options);
  if (!covariance.Compute(blocks, problem)) throw std::runtime_error("Ceres finds no covariance");
  double sum = 0.0;
  for (const double* pose : poses) {
    RowMajor<6, 6> block;
    covariance.GetCovarianceBlockInTangentSpace(pose, pose, block.data());
    sum += block.trace();
  }
  const double seconds = watch.Seconds();
  return {sum, sum, seconds, 1, {{seconds, sum}}};
}

}  // namespace ch5::peer
