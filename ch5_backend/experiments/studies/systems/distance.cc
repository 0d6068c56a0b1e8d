// Errors that grow with the distance, and what a larger window buys.  Geiger, Lenz, Urtasun, CVPR 2012; Leutenegger et al.,
// IJRR 2015, §5
#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/files/recording_file.h"

namespace ch5 {
CsvTable DistanceTable(int /*trial*/, const std::filesystem::path& data) {
  CsvTable table("recording,policy,path_m,share,distance_m,segments,q05,q25,q50,q75,q95");
  for (const std::string name : {"simulated", "euroc_v1_01_easy", "tango_walk"}) {
    const Recording recording = name == "simulated" ? SimulatedOdometryRecording() : ReadRecording(data / name);
    for (auto&& policy : AllPolicies()) {
      const OdometryRun run = RunOdometry(recording, EstimatorOptions{recording.calibration}, std::move(policy));
      for (const LengthErrors& errors :
           ErrorsOverLengths({run.states}, recording.truth, {0.01, 0.02, 0.05, 0.1, 0.2})) {
        const auto at = [&](double q) { return QuantileOfSorted(errors.position, q); };
        table.Row(name, run.policy, errors.length / errors.share, errors.share, errors.length, errors.position.size(),
                  at(0.05), at(0.25), at(0.5), at(0.75), at(0.95));
      }
    }
  }
  return table;
}

CsvTable WindowSizeTable(int trial, const std::filesystem::path& data) {
  CsvTable table("recording,trial,keyframes,temporal_frames,ate_m,restarts,milliseconds");
  const bool real = trial == 0;
  const Recording recording =
      real ? ReadRecording(data / "euroc_v1_01_easy") : SimulatedOdometryRecording(static_cast<uint64_t>(trial));
  for (const int keyframes : {1, 2, 3, 5, 8, 12}) {
    for (const int temporal : {2, 3, 5, 8}) {
      const OdometryRun run =
          RunOdometry(recording, EstimatorOptions{recording.calibration}, MakeOkvisPolicy({keyframes, temporal}));
      table.Row(real ? "euroc_v1_01_easy" : "simulated", trial, keyframes, temporal,
                run.error ? run.error->position_rmse : kNoNumber, run.restarts, run.milliseconds);
    }
  }
  return table;
}

}  // namespace ch5
