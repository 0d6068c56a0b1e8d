#include "ch5_backend/experiments/studies/gauge/gauge_solve.h"

#include <cmath>
#include <ctime>
#include <stdexcept>

#include "ch5_backend/math/psd.h"
#include "ch5_backend/sparse/sparse_solver.h"
#include "ch5_backend/types/edge_se3_prior.h"

namespace ch5 {
namespace {

// Root mean square of the observations' ‖r‖ [px], and the priors' ‖r‖.
void AppendErrors(const VisualInertialScene& scene, const Graph& graph, GaugeRun* run) {
  double pixels = 0.0, priors = 0.0;
  int observations = 0;
  for (const auto& edge : graph.Edges()) {
    const std::string type = edge->TypeInfo();
    if (type == "EdgeImu") continue;
    edge->ComputeResidual();
    if (type == "EdgeReprojectionXYZ") {
      pixels += edge->Residual().squaredNorm();
      ++observations;
    } else {
      priors += edge->Residual().squaredNorm();
    }
  }
  run->reprojection_px.push_back(scene.calibration.fx * std::sqrt(pixels / observations));
  run->prior_error.push_back(std::sqrt(priors));
}

void AddPriors(const VisualInertialScene& scene, const GaugeMethod& method, VisualInertialBa* problem) {
  if (method.place == PriorPlace::kGauge) {
    problem->graph.AddEdge(std::make_shared<EdgeGaugePrior>(problem->first, method.weight));
    return;
  }
  for (size_t i = 0; i < (method.place == PriorPlace::kFirstPose ? 1u : 2u); ++i) {
    const Transform& T_W_B = scene.initial[i].T_W_B;
    auto edge = std::make_shared<EdgeSE3Prior>(problem->poses[i], T_W_B.q, T_W_B.p);
    edge->SetInformation(method.weight * Mat66::Identity());
    problem->graph.AddEdge(edge);
  }
}

}  // namespace

GaugeSettings::GaugeSettings() {
  solve.max_iterations = 100;
  solve.tau = 1e-4;
}

std::vector<HeldDirections> HoldBiases(const VisualInertialBa& problem) {
  std::vector<HeldDirections> held;
  for (const auto& speed_bias : problem.speed_biases) {
    held.push_back({speed_bias, [] { return MatXX::Identity(9, 9).bottomRows(6); }});
  }
  return held;
}

void HandleGauge(const VisualInertialScene& scene, const GaugeMethod& method, VisualInertialBa* problem,
                 SparseOptimizer* optimizer) {
  std::vector<HeldDirections> held = HoldBiases(*problem);
  if (method.handling == GaugeHandling::kFixation) held.push_back(HoldGauge(problem->first));
  if (method.handling == GaugeHandling::kPrior && method.weight > 0.0) AddPriors(scene, method, problem);
  if (method.handling == GaugeHandling::kPseudoInverse) {
    optimizer->SetReducedSolver(MakePseudoInverse(NumGaugeDirections(GaugeGroup::kVisualInertial)));
  }
  optimizer->Hold(std::move(held));
}

std::vector<int> RowsInHessian(const Vertices& vertices) {
  std::vector<int> rows;
  for (const auto& vertex : vertices) {
    for (int k = 0; k < vertex->LocalDimension(); ++k) rows.push_back(vertex->OrderingId() + k);
  }
  return rows;
}

GaugeSolution SolveForCovariance(const VisualInertialScene& scene, GaugeHandling handling) {
  GaugeSolution solution;
  solution.problem = BuildVisualInertial(scene);
  SparseOptimizer optimizer(&solution.problem.graph);
  HandleGauge(scene, {handling}, &solution.problem, &optimizer);
  GaugeSettings settings;
  settings.solve.cost_tolerance = 1e-15;
  optimizer.SetDamping(settings.damping);
  solution.summary = optimizer.Solve(settings.solve);
  for (size_t i = 0; i < solution.problem.poses.size(); ++i) {
    solution.vertices.push_back(solution.problem.poses[i]);
    solution.vertices.push_back(solution.problem.speed_biases[i]);
  }
  for (const auto& point : solution.problem.points) solution.vertices.push_back(point);
  solution.held = HoldBiases(solution.problem);
  if (handling == GaugeHandling::kFixation) solution.held.push_back(HoldGauge(solution.problem.first));

  SparseSolver solver(&solution.problem.graph);
  solver.Hold(solution.held);
  solver.SetOrdering();
  solver.MakeHessian();
  MatXX covariance = PseudoInversePsd(solver.DenseHessian(), handling == GaugeHandling::kFree ? 4 : 0);
  for (const auto& [pose, projection] : solver.HeldPoses()) {
    const int row = solver.GetStructure().pose_offset[pose], dim = static_cast<int>(projection.rows());
    covariance.middleRows(row, dim) = (projection * covariance.middleRows(row, dim)).eval();
    covariance.middleCols(row, dim) = (covariance.middleCols(row, dim) * projection).eval();
  }
  const std::vector<int> rows = RowsInHessian(solution.vertices);
  solution.covariance = covariance(rows, rows);
  return solution;
}

GaugeRun SolveGauge(const VisualInertialScene& scene, const GaugeMethod& method, const GaugeSettings& settings) {
  GaugeRun run;
  VisualInertialBa problem = BuildVisualInertial(scene);
  SparseOptimizer optimizer(&problem.graph);
  HandleGauge(scene, method, &problem, &optimizer);
  optimizer.SetDamping(settings.damping);
  SolveOptions options = settings.solve;
  if (method.handling == GaugeHandling::kPseudoInverse) options.algorithm = Algorithm::kGaussNewton;
  double watching = 0.0;  // processor time of the errors, which is not the solver's
  options.callback = [&](const IterationInfo& info) {
    const std::clock_t begin = std::clock();
    AppendErrors(scene, problem.graph, &run);
    watching += static_cast<double>(std::clock() - begin);
    return !settings.solve.callback || settings.solve.callback(info);
  };
  const std::clock_t start = std::clock();
  run.summary = optimizer.Solve(options);
  run.milliseconds = 1e3 * (static_cast<double>(std::clock() - start) - watching) / CLOCKS_PER_SEC;

  const std::vector<StampedState> estimate = KeyframesOf(scene, problem);
  const auto error =
      CompareTrajectories(estimate, scene.truth, AlignFirstPose(estimate.front().T_W_B, scene.truth.front().T_W_B));
  if (!error) throw std::runtime_error("SolveGauge: the estimate cannot be compared with the truth");
  run.error = *error;
  return run;
}

}  // namespace ch5
