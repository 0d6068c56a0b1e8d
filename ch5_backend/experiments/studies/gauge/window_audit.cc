// Which directions of the gauge sliding windows leave free, and which they fill with information by mistake.  Huang (2010)
#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"
#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/experiments/studies/window/wrapped_policy.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

constexpr int kImages = 10;  // from audit to audit

Recording RecordingOf(int trial) {
  SimulationOptions options;
  options.calibration.camera_rate = 10.0;
  options.camera.max_tracks = 40;
  options.camera.seed = 2 + static_cast<uint64_t>(trial);
  options.imu.seed = 1 + static_cast<uint64_t>(trial);
  return SimulateInRoom({12.0, /*standstill_seconds=*/2.0}, 1000, options);
}

// The measurements alone, the prior alone at its first estimates, and the window's H, which is their sum. The prior that
// a policy itself places on the gauge is no part of it.
std::vector<std::pair<const char*, std::vector<GaugeLeak>>> Audit(const Window& window) {
  GaugeOptions options;
  options.group = GaugeGroup::kMonocular;  // roll, pitch and scale too: these are known
  options.local_poses = window.LocalPoses();
  std::vector<std::shared_ptr<Edge>> measurements, all;
  for (const auto& edge : window.graph.Edges()) {
    if (edge != window.prior && edge != window.gauge_prior) measurements.push_back(edge);
    if (edge != window.gauge_prior) all.push_back(edge);
  }
  return {{"measurements", AuditGauge(measurements, options)},
          {"prior", AuditPrior(window.prior->GetPrior(), options)},
          {"window", AuditGauge(all, options)}};
}

}  // namespace

CsvTable WindowAuditTable(int trial, const std::filesystem::path&) {
  CsvTable table("policy,constraints,trial,t_s,part,direction,information,relative");
  const Recording recording = RecordingOf(trial);
  for (const auto& [name, constraints] : {std::pair("none", ObservabilityConstraints::kNone),
                                          {"marginalized edges", ObservabilityConstraints::kMarginalizedEdges}}) {
    for (auto&& policy : AllPolicies()) {
      EstimatorOptions options{recording.calibration};
      options.observability_constraints = constraints;
      const std::string policy_name = policy->Name();
      int windows = 0;  // with a prior; audited is what a solve has seen, before its window slides
      const auto watch = [&, name = name](Window* window, const std::function<void()>& slide) {
        if (window->prior && ++windows % kImages == 0) {
          for (const auto& [part, leaks] : Audit(*window)) {
            for (const GaugeLeak& leak : leaks) {
              table.Row(policy_name, name, trial, window->frames.back().t, part, leak.direction, leak.information,
                        leak.relative);
            }
          }
        }
        slide();
      };
      RunOdometry(recording, options, std::make_unique<WrappedPolicy>(std::move(policy), watch));
    }
  }
  return table;
}

}  // namespace ch5
