#include <string>

#include "ch5_backend/dense/problem.h"
#include "ch5_backend/experiments/studies/solver/perturbed_scene.h"
#include "ch5_backend/experiments/studies/solver/rosenbrock.h"
#include "ch5_backend/experiments/studies/solver/solver_studies.h"
#include "ch5_backend/files/tables/csv.h"

namespace ch5 {
namespace {

const char* NameOf(StepType type) {
  switch (type) {
    case StepType::kGaussNewton: return "Gauss-Newton";
    case StepType::kDamped: return "damped";
    case StepType::kSteepestDescent: return "steepest descent";
    case StepType::kDogleg: return "dogleg";
    case StepType::kNone: break;
  }
  return "none";
}

// Every iterate on the way from (−1.2, 1).
void AppendPath(const std::string& name, Algorithm algorithm, CsvTable* table) {
  Graph graph;
  const auto xy = BuildRosenbrock(&graph);
  Problem problem(&graph);
  SolveOptions options;
  options.algorithm = algorithm;
  options.max_iterations = 60;
  options.tau = 1e-3;
  options.initial_radius = 0.5;
  options.callback = [&](const IterationInfo& info) {
    const Vec2& p = xy->GetEstimate();
    table->Row(name, info.iteration, p.x(), p.y(), info.cost, NameOf(info.step_type), info.lambda, info.trials);
    return true;
  };
  problem.Solve(options);
}

void AppendDogleg(double radius, CsvTable* table) {
  MonoBa ba = BuildPerturbed(6, 60, 0.5, 0.1);
  Problem problem(&ba.graph);
  SolveOptions options;
  options.algorithm = Algorithm::kDogleg;
  options.initial_radius = radius;
  options.max_iterations = 40;
  for (const IterationInfo& info : problem.Solve(options).trace) {
    table->Row(radius, info.iteration, info.cost, info.lambda, info.gain_ratio, info.step_norm, info.trials,
               NameOf(info.step_type));
  }
}

}  // namespace

void RunStepStudy(const std::filesystem::path& csv) {
  CsvTable paths("algorithm,iteration,x,y,cost,step,parameter,trials");
  AppendPath("gauss-newton", Algorithm::kGaussNewton, &paths);
  AppendPath("levenberg-marquardt", Algorithm::kLevenbergMarquardt, &paths);
  AppendPath("dogleg", Algorithm::kDogleg, &paths);
  paths.Write(csv / "solver_paths.csv");
  CsvTable dogleg("first_radius,iteration,cost,radius,gain_ratio,step_norm,trials,step");
  for (const double radius : {0.01, 0.1, 1.0, 1e4}) AppendDogleg(radius, &dogleg);
  dogleg.Write(csv / "solver_dogleg.csv");
}

}  // namespace ch5
