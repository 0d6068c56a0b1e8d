#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/solver/perturbed_scene.h"
#include "ch5_backend/experiments/studies/solver/rosenbrock.h"
#include "ch5_backend/experiments/studies/solver/solver_studies.h"
#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/edge_curve_fitting.h"

namespace ch5 {
namespace {

constexpr int kMaxTrials = 60;

// What a rule makes of λ (and Nielsen's ν) after a trial; a gain ratio ≤ 0 means that the step was rejected.
struct Rule {
  std::string name;
  std::function<double(double gain_ratio, double nu)> factor;
};

// Nielsen's as the course has it, λ always falling after a success; the same without that limit, as Ceres has it; and
// Marquardt's of 1963.
std::vector<Rule> Rules() {
  const auto cubic = [](double rho) { return std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * rho - 1.0, 3)); };
  return {{"nielsen", [=](double rho, double nu) { return rho > 0.0 ? std::min(2.0 / 3.0, cubic(rho)) : nu; }},
          {"ceres", [=](double rho, double nu) { return rho > 0.0 ? cubic(rho) : nu; }},
          {"tenfold", [](double rho, double) { return rho > 0.0 ? 0.1 : 10.0; }}};
}

// Levenberg-Marquardt with a rule of its own; a row a trial, until the cost has converged.
void AppendRun(const std::string& name, const Rule& rule, Problem* problem, CsvTable* table) {
  problem->SetDamping(Damping::kDiagonal);
  problem->SetOrdering();
  double cost = problem->Cost(), lambda = 1e-4, nu = 2.0;
  bool accepted = true, converged = false;
  table->Row(name, rule.name, 0, lambda, std::nan(""), 1, cost);
  VecX delta_x;
  for (int trial = 1; trial <= kMaxTrials && !converged; ++trial) {
    if (accepted) problem->MakeHessian();
    problem->SolveLinearSystem(lambda, &delta_x);
    const double model_cost_change = problem->ModelCostChange(delta_x);
    problem->UpdateStates(delta_x);
    const double new_cost = problem->Cost(), rho = (cost - new_cost) / model_cost_change;
    accepted = new_cost < cost;
    if (accepted) {
      converged = cost - new_cost <= 1e-9 * cost || new_cost < 1e-20;
      cost = new_cost;
    } else {
      problem->RollbackStates();
      converged = model_cost_change <= 1e-12 * cost;
    }
    table->Row(name, rule.name, trial, lambda, std::isfinite(rho) ? rho : std::nan(""), accepted ? 1 : 0, cost);
    lambda *= rule.factor(accepted ? rho : 0.0, nu);
    nu = accepted ? 2.0 : 2.0 * nu;
  }
}

// y = exp(a x² + b x + c) at 100 places with noise of σ = 1, started at 0 (chapter 3's example).
void BuildCurve(Graph* graph) {
  auto abc = std::make_shared<VertexVector<3>>(Vec3::Zero());
  graph->AddVertex(abc);
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const double x = i / 100.0;
    graph->AddEdge(std::make_shared<EdgeCurveFitting>(abc, x, std::exp((x + 2.0) * x + 1.0) + random.Normal()));
  }
}

CsvTable CompareRules() {
  CsvTable table("problem,rule,trial,lambda,gain_ratio,accepted,cost");
  for (const Rule& rule : Rules()) {
    Graph curve, valley;
    BuildCurve(&curve);
    BuildRosenbrock(&valley);
    MonoBa ba = BuildPerturbed(6, 60, 0.5, 0.1);
    for (const auto& [name, graph] :
         {std::pair("curve", &curve), std::pair("valley", &valley), std::pair("bundle", &ba.graph)}) {
      Problem problem(graph);
      AppendRun(name, rule, &problem, &table);
    }
  }
  return table;
}

// The step of the poses' block damped alone: λ is added to S, which was formed from the undamped H.
VecX HalfDampedStep(const Problem& problem, double lambda, Eigen::Index poses) {
  const MatXX& H = problem.Hessian();
  const VecX& b = problem.RightHandSide();
  const Eigen::Index m = H.rows() - poses;
  const MatXX inverse = H.bottomRightCorner(m, m).diagonal().cwiseInverse().asDiagonal();
  const MatXX H_pm = H.topRightCorner(poses, m);
  MatXX S = H.topLeftCorner(poses, poses) - H_pm * inverse * H_pm.transpose();
  S.diagonal().array() += lambda;
  VecX step(H.rows());
  step.head(poses) = S.ldlt().solve(b.head(poses) - H_pm * inverse * b.tail(m));
  step.tail(m) = inverse * (b.tail(m) - H_pm.transpose() * step.head(poses));
  return step;
}

// The course's scene at its start, W = I as in the course: for λ, the step of the true damped system and the other one,
// the decrease that the course's gain ratio predicts, ½ Δxᵀ(λΔx + b), and what each step really gains.
CsvTable HalfDampedSteps() {
  CsvTable table("relative_lambda,step,half_damped_step,relative_difference,gain_ratio,half_damped_gain_ratio");
  MonoBa ba = BuildMonoBa(SimulateMonoBa(MonoBaOptions()), Gauge::kFixTwoFrames, 1.0, 0.0);
  Problem problem(&ba.graph);
  problem.SetOrdering();
  problem.MakeHessian();
  const double cost = problem.Cost();
  const double largest = problem.HessianDiagonal().maxCoeff();
  const auto gained = [&](const VecX& step) {
    problem.UpdateStates(step);
    const double now = problem.Cost();
    problem.RollbackStates();
    return cost - now;
  };
  for (int k = -24; k <= 8; ++k) {
    const double lambda = largest * std::pow(10.0, 0.25 * k);
    VecX whole;
    problem.SolveLinearSystem(lambda, &whole);
    const VecX half = HalfDampedStep(problem, lambda, problem.SchurComplement().rows());
    const auto model_cost_change = [&](const VecX& dx) { return 0.5 * dx.dot(lambda * dx + problem.RightHandSide()); };
    table.Row(lambda / largest, whole.norm(), half.norm(), (half - whole).norm() / whole.norm(),
              gained(whole) / model_cost_change(whole), gained(half) / model_cost_change(half));
  }
  return table;
}

// The course's scene with W = I, W = 1/σ² and a still larger one: the same states, the cost so many times as large.
CsvTable StopTraces() {
  CsvTable table("information,iteration,cost,gradient_max");
  for (const double information : {1.0, 1e6, 1e10}) {
    MonoBa ba = BuildMonoBa(SimulateMonoBa(MonoBaOptions()), Gauge::kFixTwoFrames, information, 0.0);
    Problem problem(&ba.graph);
    SolveOptions options;
    options.max_iterations = 12;
    options.cost_tolerance = options.step_tolerance = options.gradient_tolerance = 0.0;
    for (const IterationInfo& info : problem.Solve(options).trace) {
      table.Row(information, info.iteration, info.cost, info.gradient_max);
    }
  }
  return table;
}

}  // namespace

void RunDampingStudy(const std::filesystem::path& csv) {
  CompareRules().Write(csv / "solver_rules.csv");
  HalfDampedSteps().Write(csv / "solver_half_damped.csv");
  StopTraces().Write(csv / "solver_stop.csv");
}

}  // namespace ch5
