#include "ch5_backend/experiments/studies/host_noise_study.h"

#include <cmath>

#include "ch5_backend/experiments/studies/odometry.h"

namespace ch5 {
namespace {

struct Way {
  const char* hosts;
  double cauchy;
  bool noisy;
};
constexpr Way kWays[] = {{"exact with loss", 1.0, false}, {"exact", 0.0, false}, {"noisy", 0.0, true}};

}  // namespace

CsvTable HostNoiseTable() {
  return CsvTable("recording,policy,hosts,images,restarts,ate_m,scale_error,rotation_error_deg,milliseconds");
}

void AppendHostNoise(const std::string& name, const Recording& recording, CsvTable* table) {
  for (const Way& way : kWays) {
    for (auto&& policy : AllPolicies()) {
      EstimatorOptions options{recording.calibration};
      options.weights.cauchy = way.cauchy;
      options.weights.noisy_hosts = way.noisy;
      const OdometryRun run = RunOdometry(recording, options, std::move(policy));
      double seconds = 0.0;
      for (const ImageResult& row : run.rows) seconds += row.seconds;
      const TrajectoryError error = run.error.value_or(TrajectoryError());
      table->Row(name, run.policy, way.hosts, run.states.size(), run.restarts, error.position_rmse, error.scale - 1.0,
                 error.rotation_rmse * 180.0 / M_PI, 1e3 * seconds / static_cast<double>(run.rows.size()));
    }
  }
}

}  // namespace ch5
