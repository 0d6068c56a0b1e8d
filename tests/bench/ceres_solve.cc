#include "tests/bench/ceres_solve.h"

#include <chrono>
#include <stdexcept>

#include "tests/bench/memory.h"

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

}  // namespace

PeerResult SolveWithCeres(const PeerOptions& options, std::shared_ptr<ceres::ParameterBlockOrdering> ordering,
                          ceres::Problem* problem) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = Type(options.linear_solver);
  ceres_options.linear_solver_ordering = std::move(ordering);
  ceres_options.preconditioner_type = ceres::SCHUR_JACOBI;
  ceres_options.dense_linear_algebra_library_type = ceres::LAPACK;
  ceres_options.trust_region_strategy_type = options.dogleg ? ceres::DOGLEG : ceres::LEVENBERG_MARQUARDT;
  ceres_options.num_threads = options.threads;
  ceres_options.max_num_iterations = options.iterations;
  ceres_options.function_tolerance = options.tolerance;
  ceres_options.gradient_tolerance = ceres_options.parameter_tolerance = 0.0;
  ceres_options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const double bytes_before = bench::MemoryBytes("VmRSS:");
  ceres::Solve(ceres_options, problem, &summary);
  PeerResult result{summary.initial_cost,
                    summary.final_cost,
                    summary.total_time_in_seconds,
                    static_cast<int>(summary.iterations.size()) - 1,
                    {},
                    bytes_before};
  for (const auto& it : summary.iterations) {
    result.trace.push_back({it.cumulative_time_in_seconds + summary.preprocessor_time_in_seconds, it.cost});
  }
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
  const auto start = std::chrono::steady_clock::now();
  ceres::Covariance covariance(ceres_options);
  if (!covariance.Compute(blocks, problem)) throw std::runtime_error("Ceres finds no covariance");
  double sum = 0.0;
  for (const double* pose : poses) {
    RowMajor<6, 6> block;
    covariance.GetCovarianceBlockInTangentSpace(pose, pose, block.data());
    sum += block.trace();
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {sum, sum, seconds, 1, {{seconds, sum}}};
}

}  // namespace ch5::peer
