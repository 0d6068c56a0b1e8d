// What VINS-Mono finds of its camera while it flies.  Qin & Shen, IROS 2018 (the clock's offset)
#include <cmath>

#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

constexpr double kLate = 0.01, kDegree = M_PI / 180.0, kTurned = 2.0 * kDegree;

Recording HandheldFlight(int trial, double late) {
  HandheldOptions path{20.0, /*standstill_seconds=*/2.0};
  path.seed = 1 + static_cast<uint64_t>(trial);
  SimulationOptions simulation;
  simulation.camera.max_tracks = 60;
  simulation.camera.time_offset = late;
  simulation.camera.seed = 2 + static_cast<uint64_t>(trial);
  simulation.imu.seed = 1 + static_cast<uint64_t>(trial);
  return SimulateInRoom(path, 1500, simulation, path.seed);
}

}  // namespace

CsvTable CalibrationTable(int trial, const std::filesystem::path&) {
  constexpr size_t kImages = 10;  // from row to row
  CsvTable table("policy,quantity,trial,t_s,error");
  for (const bool offset : {true, false}) {
    const Recording recording = HandheldFlight(trial, offset ? kLate : 0.0);
    EstimatorOptions options{recording.calibration};
    const Qd truth = options.calibration.T_B_C.q;
    options.estimate_time_offset = offset;
    options.estimate_extrinsic = !offset;
    if (!offset) options.calibration.T_B_C.q = truth * ExpSO3(kTurned * Vec3(1, -1, 1).normalized());
    for (auto&& policy : AllPolicies()) {
      const std::string name = policy->Name();
      size_t image = 0;
      RunOdometry(recording, options, std::move(policy), [&](const Estimator& now, const ImageResult& row) {
        if (!row.report.state || image++ % kImages != 0) return;
        const double error = offset ? 1e3 * std::abs(now.TimeOffset() - kLate)
                                    : now.GetWindow().T_B_C().q.angularDistance(truth) / kDegree;
        table.Row(name, offset ? "offset_ms" : "rotation_deg", trial, row.t, error);
      });
    }
  }
  return table;
}

}  // namespace ch5
