#include "ch5_backend/experiments/studies/prior_study.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/math/median.h"

namespace ch5 {
namespace {

constexpr int kTrials = 40;

MonoBaOptions Perturbed() {
  MonoBaOptions options;
  options.position_sigma = 0.1;
  options.rotation_sigma = 2.0 * M_PI / 180.0;
  return options;
}

// The costs of the observations and of the priors, apart.
void SplitCost(const Graph& graph, PriorRun* run) {
  for (const auto& edge : graph.Edges()) {
    edge->ComputeResidual();
    const bool is_prior = edge->TypeInfo() == "EdgeSE3Prior";
    (is_prior ? run->prior_cost : run->reprojection_cost) += edge->Cost();
  }
}

}  // namespace

std::vector<PriorVariant> PriorVariants() {
  const double information = 1.0 / std::pow(MonoBaOptions().pixel_sigma, 2);
  return {{"course", MonoBaOptions(), Gauge::kPriorTwoFrames, 1.0, Damping::kIdentity},
          {"perturbed", Perturbed(), Gauge::kPriorTwoFrames, information, Damping::kDiagonal},
          {"minimal", Perturbed(), Gauge::kPriorMinimal, information, Damping::kDiagonal}};
}

std::vector<double> PriorWeights() {
  std::vector<double> weights = {0.0};
  for (int exponent = -3; exponent < 10; ++exponent) {
    for (const char* digit : {"1e", "3e"}) weights.push_back(std::stod(digit + std::to_string(exponent)));
  }
  weights.push_back(1e10);
  return weights;
}

SolveOptions TightOptions() {
  SolveOptions options;
  options.max_iterations = 200;
  options.cost_tolerance = 1e-12;
  options.gradient_tolerance = 1e-14;
  options.step_tolerance = 1e-12;
  return options;
}

SolveOptions UsualOptions() {
  SolveOptions options;
  options.max_iterations = 100;
  return options;
}

PriorRun RunPrior(const PriorVariant& variant, const MonoBaScene& scene, double weight, const SolveOptions& options) {
  PriorRun run;
  MonoBa ba = BuildMonoBa(scene, variant.gauge, variant.pixel_information, weight);
  Problem problem(&ba.graph);
  problem.SetDamping(variant.damping);
  const std::clock_t start = std::clock();
  run.summary = problem.Solve(options);
  run.milliseconds = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  SplitCost(ba.graph, &run);

  const Reconstruction truth = TruthOf(scene), estimate = EstimateOf(scene, ba);
  run.drift_position = (estimate.frames[0].p - truth.frames[0].p).norm();
  run.drift_rotation = LogSO3(truth.frames[0].q.conjugate() * estimate.frames[0].q).norm();
  run.rmse = CompareAligned(estimate, truth).value();
  return run;
}

namespace {

struct PriorTables {
  CsvTable sweep{
      "variant,weight,iterations,cost_evaluations,milliseconds,reprojection_cost,prior_cost,drift_position,"
      "drift_rotation,rmse_position,rmse_rotation,rmse_landmark,termination"};
  CsvTable trace{"variant,weight,iteration,cost,lambda"};
  CsvTable trials{"variant,weight,trials,converged,mean_iterations,max_iterations,mean_drift_position"};
  CsvTable damping{"damping,weight,iterations,lambda0"};
};

// Median time of a solve [ms] per variant and weight. Each round goes through all of them, so that a moment's
// disturbance touches one round of a few, and no median.
std::vector<std::vector<double>> MedianTimes(const std::vector<PriorVariant>& variants,
                                             const std::vector<double>& weights) {
  constexpr int kRounds = 7;
  std::vector<std::vector<std::vector<double>>> times(variants.size(),
                                                      std::vector<std::vector<double>>(weights.size()));
  for (int round = 0; round < kRounds; ++round) {
    for (size_t v = 0; v < variants.size(); ++v) {
      const MonoBaScene scene = SimulateMonoBa(variants[v].scene);
      for (size_t i = 0; i < weights.size(); ++i) {
        times[v][i].push_back(RunPrior(variants[v], scene, weights[i], TightOptions()).milliseconds);
      }
    }
  }
  std::vector<std::vector<double>> medians(variants.size());
  for (size_t v = 0; v < variants.size(); ++v) {
    for (const auto& rounds : times[v]) medians[v].push_back(Median(rounds));
  }
  return medians;
}

// One scene at one weight: what a student's own sweep shows.
void AppendRun(const PriorVariant& variant, const MonoBaScene& scene, double weight, double milliseconds,
               PriorTables* tables) {
  const PriorRun run = RunPrior(variant, scene, weight, TightOptions());
  const Summary& summary = run.summary;
  tables->sweep.Row(variant.name, weight, summary.iterations, summary.cost_evaluations, milliseconds,
                    run.reprojection_cost, run.prior_cost, run.drift_position, run.drift_rotation, run.rmse.position,
                    run.rmse.rotation, run.rmse.point, ToString(summary.termination));
  for (const IterationInfo& info : summary.trace) {
    tables->trace.Row(variant.name, weight, info.iteration, info.cost, info.lambda);
  }
}

// Many scenes, differing in the seed alone, with the usual stop rules.
void AverageScenes(const PriorVariant& variant, double weight, PriorTables* tables) {
  double iterations = 0.0, most = 0.0, converged = 0.0, drift = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    MonoBaOptions options = variant.scene;
    options.seed = static_cast<uint64_t>(100 + trial);
    const PriorRun run = RunPrior(variant, SimulateMonoBa(options), weight, UsualOptions());
    iterations += run.summary.iterations;
    most = std::max<double>(most, run.summary.iterations);
    converged += IsConverged(run.summary.termination);
    drift += run.drift_position;
  }
  tables->trials.Row(variant.name, weight, kTrials, converged / kTrials, iterations / kTrials, most, drift / kTrials);
}

// The control: the course's variant with nothing changed but the damping.
void CompareDampings(double weight, PriorTables* tables) {
  PriorVariant variant = PriorVariants().front();
  const MonoBaScene scene = SimulateMonoBa(variant.scene);
  for (const auto& [name, damping] : {std::pair("identity", Damping::kIdentity), {"diagonal", Damping::kDiagonal}}) {
    variant.damping = damping;
    const Summary summary = RunPrior(variant, scene, weight, TightOptions()).summary;
    tables->damping.Row(name, weight, summary.iterations, summary.trace.at(1).lambda);
  }
}

}  // namespace

void RunPriorStudy(const std::filesystem::path& csv, const std::function<void(double)>& progress) {
  PriorTables tables;
  const auto variants = PriorVariants();
  const auto weights = PriorWeights();
  progress(0.0);
  const auto milliseconds = MedianTimes(variants, weights);
  double done = 0.0;
  for (size_t v = 0; v < variants.size(); ++v) {
    const MonoBaScene scene = SimulateMonoBa(variants[v].scene);
    for (size_t i = 0; i < weights.size(); ++i) {
      AppendRun(variants[v], scene, weights[i], milliseconds[v][i], &tables);
      AverageScenes(variants[v], weights[i], &tables);
      progress(++done / static_cast<double>(variants.size() * weights.size()));
    }
  }
  for (const double weight : weights) CompareDampings(weight, &tables);
  tables.sweep.Write(csv / "prior_sweep.csv");
  tables.trace.Write(csv / "prior_trace.csv");
  tables.trials.Write(csv / "prior_trials.csv");
  tables.damping.Write(csv / "prior_damping.csv");
}

}  // namespace ch5
