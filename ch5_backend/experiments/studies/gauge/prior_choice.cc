// Which weight should I choose? What the curve of iterations over the prior's weight owes to damping, stop rules, start
// and the place of the prior, on the gauge paper's problem.
#include <cmath>

#include "ch5_backend/experiments/studies/gauge/gauge_solve.h"
#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"

namespace ch5 {
namespace {

constexpr std::pair<const char*, PriorPlace> kPlaces[] = {
    {"gauge", PriorPlace::kGauge}, {"pose 0", PriorPlace::kFirstPose}, {"poses 0 and 1", PriorPlace::kFirstTwoPoses}};

// "identity": the course's λ₀ = τ max diag(H), which grows with the weight; "diagonal": λ diag(H); "radius": Dogleg's,
// which asks how long a step is and not how stiff H.
GaugeSettings SettingsOf(const std::string& damping) {
  GaugeSettings settings;
  if (damping == "identity") {
    settings.damping = Damping::kIdentity;
    settings.solve.tau = 1e-5;
  }
  if (damping == "radius") {
    settings.solve.algorithm = Algorithm::kDogleg;
    settings.solve.initial_radius = 1.0;  // [m, rad, m/s], of all unknowns together
  }
  return settings;
}

// The original course stops once ‖Δx‖² ≤ 1e-6, whatever the units and however strongly damped.
void StopAbsolutely(GaugeSettings* settings) {
  settings->solve.cost_tolerance = settings->solve.step_tolerance = settings->solve.gradient_tolerance = 0.0;
  settings->solve.callback = [](const IterationInfo& info) {
    return info.iteration == 0 || info.step_norm * info.step_norm > 1e-6;
  };
}

}  // namespace

CsvTable PriorChoiceTable(int trial, const std::filesystem::path&) {
  CsvTable table("trial,start,place,damping,stop,weight,iterations,trials_of_steps,position_m,reprojection_px");
  for (const char* start : {"perturbed", "truth"}) {
    VisualInertialOptions options = GaugeConfigurations(trial).front().options;
    if (start == std::string("truth"))
      options.start = {0.0, 0.0, 0.0, 0.075};  // only the points are unknown, as in the course
    const VisualInertialScene scene = SimulateVisualInertial(options);
    for (const auto& [place, prior] : kPlaces) {
      for (const char* damping : {"identity", "diagonal", "radius"}) {
        for (const char* stop : {"relative", "absolute"}) {
          for (int exponent = -1; exponent <= 10; ++exponent) {
            const double weight = exponent < 0 ? 0.0 : std::pow(10.0, exponent);
            GaugeSettings settings = SettingsOf(damping);
            if (stop == std::string("absolute")) StopAbsolutely(&settings);
            const GaugeRun run = SolveGauge(scene, {GaugeHandling::kPrior, weight, prior}, settings);
            table.Row(trial, start, place, damping, stop, weight, run.summary.iterations, run.summary.cost_evaluations,
                      run.error.position_rmse, run.reprojection_px.back());
          }
        }
      }
    }
  }
  return table;
}

}  // namespace ch5
