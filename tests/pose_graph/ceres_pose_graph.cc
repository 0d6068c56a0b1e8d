/// Our pose-graph optimiser against Ceres' SPARSE_NORMAL_CHOLESKY: same residuals, analytic Jacobians, start, damping
/// by the diagonal, tolerances and threads, taking turns in one process.
///
///   ceres_pose_graph FILE.g2o [REPETITIONS [THREADS]]
///
/// Built on demand (target ceres_pose_graph) where Ceres is found.

#include <ceres/ceres.h>
#include <unistd.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "ch5_backend/apps/studies/pose_graph_study.h"
#include "ch5_backend/math/dense_kernels.h"
#include "ch5_backend/types/edge_between.h"

namespace {

using namespace ch5;

// [p, q] with the increment [δp, δθ]; the cost functions give derivatives by the increment, in the first six columns.
class PoseManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    const Qd q = Qd(x[6], x[3], x[4], x[5]) * ExpSO3(Eigen::Map<const Vec3>(delta + 3));
    Eigen::Map<Vec3>{x_plus_delta} = Eigen::Map<const Vec3>(x) + Eigen::Map<const Vec3>(delta);
    Eigen::Map<Eigen::Vector4d>(x_plus_delta + 3) = q.normalized().coeffs();
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>>{J}.setIdentity();
    return true;
  }
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
};

// The residual of EdgeSE3Between, whitened by a factor of W that is worked out once.
class Between : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  explicit Between(const EdgeSE3Between& edge)
      : root_(Mat66(edge.W()).llt().matrixU()),
        i_(std::make_shared<VertexPose>()),
        j_(std::make_shared<VertexPose>()),
        edge_(i_, j_, edge.q_z(), edge.p_z()) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    i_->SetEstimate(Eigen::Map<const Vec7>(x[0]));
    j_->SetEstimate(Eigen::Map<const Vec7>(x[1]));
    edge_.ComputeResidual();
    Eigen::Map<Vec6>{residuals}.noalias() = root_ * edge_.GetResidual();
    if (!jacobians) return true;
    edge_.ComputeJacobians();
    if (jacobians[0]) Fill(std::as_const(edge_).J<0>(), jacobians[0]);
    if (jacobians[1]) Fill(std::as_const(edge_).J<1>(), jacobians[1]);
    return true;
  }

 private:
  void Fill(const Mat66& J, double* out) const {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> target(out);
    target.leftCols<6>().noalias() = root_ * J;
    target.col(6).setZero();
  }

  Mat66 root_;
  std::shared_ptr<VertexPose> i_, j_;
  mutable EdgeSE3Between edge_;  // each block of a problem is evaluated by one thread at a time
};

struct Result {
  double initial_cost, final_cost, seconds;
  int iterations;
  std::vector<std::pair<double, double>> trace;  // seconds, cost

  double SecondsTo(double cost) const {
    for (const auto& [seconds, reached] : trace) {
      if (reached <= cost) return seconds;
    }
    return -1.0;
  }
};

Result RunCeres(const std::string& path, int threads) {
  G2oFile file = ReadG2o(path);
  FixFreeParts(file.graph);
  std::vector<Vec7> states;
  for (const auto& vertex : file.graph.Vertices()) states.push_back(vertex->Parameters());
  ceres::Problem problem;
  auto* manifold = new PoseManifold;
  for (const auto& edge : file.graph.Edges()) {
    const int i = edge->Vertices()[0]->Id(), j = edge->Vertices()[1]->Id();
    for (const int k : {i, j}) problem.AddParameterBlock(states[k].data(), 7, manifold);
    problem.AddResidualBlock(new Between(dynamic_cast<const EdgeSE3Between&>(*edge)), nullptr, states[i].data(),
                             states[j].data());
  }
  for (const auto& vertex : file.graph.Vertices()) {
    if (vertex->IsFixed()) problem.SetParameterBlockConstant(states[vertex->Id()].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = threads;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-6;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  Result result{summary.initial_cost,
                summary.final_cost,
                summary.total_time_in_seconds,
                static_cast<int>(summary.iterations.size()) - 1,
                {}};
  for (const auto& it : summary.iterations) {
    result.trace.emplace_back(it.cumulative_time_in_seconds + summary.preprocessor_time_in_seconds, it.cost);
  }
  return result;
}

Result RunOurs(const std::string& path, int threads) {
  G2oFile file = ReadG2o(path);
  const PoseGraphStudy study = SolvePoseGraph({50, threads, 0.0}, &file);
  const Summary& summary = study.summary;
  Result result{summary.initial_cost, summary.final_cost, summary.seconds, summary.iterations, {}};
  for (const IterationInfo& info : summary.trace) result.trace.emplace_back(info.seconds, info.cost);
  return result;
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void Compare(const char* what, const std::vector<Result>& ours, const std::vector<Result>& ceres,
             const std::function<double(const Result&)>& measure) {
  std::vector<double> a, b, ratios;
  for (size_t k = 0; k < ours.size(); ++k) {
    a.push_back(1e3 * measure(ours[k]));
    b.push_back(1e3 * measure(ceres[k]));
    ratios.push_back(b.back() / a.back());
  }
  std::printf("%-22s %10.2f ms %10.2f ms   ratio %.2f\n", what, Median(a), Median(b), Median(ratios));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: %s FILE.g2o [REPETITIONS [THREADS]]\n", argv[0]), 2;
  // BLAS under Ceres' sparse Cholesky is fastest with one thread on matrices this small, and reads this when loaded.
  if (!std::getenv("OPENBLAS_NUM_THREADS")) {
    setenv("OPENBLAS_NUM_THREADS", "1", 1);
    execv("/proc/self/exe", argv);
  }
  const int repetitions = argc > 2 ? std::atoi(argv[2]) : 5, threads = argc > 3 ? std::atoi(argv[3]) : 1;
  std::vector<Result> ours, peer;
  for (int k = 0; k < repetitions; ++k) {
    ours.push_back(RunOurs(argv[1], threads));
    peer.push_back(RunCeres(argv[1], threads));
  }
  std::printf("%s, %d repetitions, %d threads, %s\n", argv[1], repetitions, threads, kernels::InstructionSet());
  std::printf("%-22s %13s %13s\n", "", "ours", "Ceres");
  std::printf("%-22s %13.6e %13.6e\n", "cost at the start", ours[0].initial_cost, peer[0].initial_cost);
  std::printf("%-22s %13.6e %13.6e\n", "cost at the end", ours[0].final_cost, peer[0].final_cost);
  std::printf("%-22s %13.6f %13.6f\n", "chi2 at the end", 2 * ours[0].final_cost, 2 * peer[0].final_cost);
  std::printf("%-22s %13d %13d\n", "iterations", ours[0].iterations, peer[0].iterations);
  const double best = std::min(ours[0].final_cost, peer[0].final_cost);
  Compare("total", ours, peer, [](const Result& r) { return r.seconds; });
  Compare("per iteration", ours, peer, [](const Result& r) { return r.seconds / r.iterations; });
  Compare("to 1 % of the best", ours, peer, [&](const Result& r) { return r.SecondsTo(1.01 * best); });
  Compare("to 0.1 %", ours, peer, [&](const Result& r) { return r.SecondsTo(1.001 * best); });
}
