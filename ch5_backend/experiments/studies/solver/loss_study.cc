#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "ch5_backend/evaluate/reconstruction.h"
#include "ch5_backend/experiments/studies/solver/solver_studies.h"
#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/sparse/sparse_optimizer.h"

namespace ch5 {
namespace {

constexpr int kTrials = 20;
using Loss = std::shared_ptr<const LossFunction>;

// Residuals are in σ: the thresholds are the usual ones for 95 % efficiency on Gaussian noise of one number (93 to
// 94 % of two), Holland & Welsch 1977.
std::vector<std::pair<std::string, Loss>> Losses(LossCorrection correction = LossCorrection::kTriggs) {
  return {{"none", std::make_shared<TrivialLoss>()},
          {"huber", std::make_shared<HuberLoss>(1.345, correction)},
          {"cauchy", std::make_shared<CauchyLoss>(2.385, correction)},
          {"tukey", std::make_shared<TukeyLoss>(4.685, correction)}};
}

CsvTable Curves() {
  CsvTable table("loss,r,half_rho,weight,second");
  for (const auto& [name, loss] : Losses()) {
    for (int i = 0; i <= 160; ++i) {
      const double r = 0.05 * i, s = r * r;
      const Rho rho = loss->Evaluate(s);
      table.Row(name, r, 0.5 * rho[0], rho[1], rho[1] + 2.0 * rho[2] * s);
    }
  }
  return table;
}

// A scene of which a fraction of the observations, the host's excepted, lies anywhere in the image.
MonoBaScene SceneWithOutliers(double fraction, uint64_t seed) {
  MonoBaOptions options{6, 60};
  options.depth_sigma = 0.5;
  options.position_sigma = 0.05;
  options.rotation_sigma = 0.01;
  options.seed = seed;
  MonoBaScene scene = SimulateMonoBa(options);
  Random random(1000 + seed);
  for (size_t frame = 1; frame < scene.pixels.size(); ++frame) {
    for (Vec2& pixel : scene.pixels[frame]) {
      const double chance = random.Uniform();
      const double v = random.Uniform(-1.0, 1.0), u = random.Uniform(-1.0, 1.0);
      if (chance < fraction) pixel = Vec2(u, v);
    }
  }
  return scene;
}

struct Outcome {
  double rmse_position, final_cost;
  int iterations;
};

Outcome SolveWith(const MonoBaScene& scene, const Loss& loss) {
  const double information = 1.0 / std::pow(MonoBaOptions().pixel_sigma, 2);
  MonoBa ba = BuildMonoBa(scene, Gauge::kPriorMinimal, information, information);
  for (const auto& edge : ba.graph.Edges()) {
    if (edge->ResidualDimension() == 2) edge->SetLossFunction(loss);
  }
  SparseOptimizer optimizer(&ba.graph);
  SolveOptions options;
  options.max_iterations = 100;
  const Summary summary = optimizer.Solve(options);
  const Reconstruction truth = TruthOf(scene);
  return {CompareAligned(EstimateOf(scene, ba), truth).value().position, summary.final_cost, summary.iterations};
}

CsvTable CompareOutliers() {
  CsvTable table("fraction,loss,trials,rmse_position_m,iterations");
  for (const double fraction : {0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4}) {
    for (const auto& [name, loss] : Losses()) {
      std::vector<double> errors, iterations;
      for (int trial = 0; trial < kTrials; ++trial) {
        const Outcome outcome = SolveWith(SceneWithOutliers(fraction, 100 + trial), loss);
        errors.push_back(outcome.rmse_position);
        iterations.push_back(outcome.iterations);
      }
      table.Row(fraction, name, kTrials, Median(errors), Median(iterations));
    }
  }
  return table;
}

// Triggs' second term, or none (IRLS): the same minimum, another way there.
CsvTable CompareCorrections() {
  CsvTable table("loss,correction,trials,final_cost,iterations");
  for (const auto& [correction, word] :
       {std::pair(LossCorrection::kTriggs, "triggs"), std::pair(LossCorrection::kIrls, "irls")}) {
    for (const auto& [name, loss] : Losses(correction)) {
      std::vector<double> costs, iterations;
      for (int trial = 0; trial < kTrials; ++trial) {
        const Outcome outcome = SolveWith(SceneWithOutliers(0.1, 100 + trial), loss);
        costs.push_back(outcome.final_cost);
        iterations.push_back(outcome.iterations);
      }
      table.Row(name, word, kTrials, Median(costs), Median(iterations));
    }
  }
  return table;
}

}  // namespace

void RunLossStudy(const std::filesystem::path& csv) {
  Curves().Write(csv / "solver_losses.csv");
  CompareOutliers().Write(csv / "solver_outliers.csv");
  CompareCorrections().Write(csv / "solver_corrections.csv");
}

}  // namespace ch5
