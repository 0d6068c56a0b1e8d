// Errors that grow with the distance, and what a larger window buys.  Geiger, Lenz, Urtasun, CVPR 2012; Leutenegger et al.,
// IJRR 2015, §5
#include <algorithm>
#include <cmath>

#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/files/recording_file.h"

namespace ch5 {
namespace {

struct Pair {
  Transform estimate, truth;  // T_W_B
  double distance;            // flown since the first [m]
};

std::vector<Pair> PairsOf(const std::vector<StampedState>& states, const std::vector<StampedState>& truth) {
  std::vector<Pair> pairs;
  for (const StampedState& state : states) {
    const auto there = StateAt(truth, state.t);
    if (!there) continue;
    const double step = pairs.empty() ? 0.0 : (there->T_W_B.p - pairs.back().truth.p).norm();
    pairs.push_back({state.T_W_B, there->T_W_B, step + (pairs.empty() ? 0.0 : pairs.back().distance)});
  }
  return pairs;
}

// How far the ends are apart after `distance` when position and yaw are laid upon each other at the beginning [m], from every image on.
std::vector<double> RelativeErrors(const std::vector<Pair>& pairs, double distance) {
  std::vector<double> errors;
  for (size_t i = 0, j = 0; i < pairs.size(); ++i) {
    while (j < pairs.size() && pairs[j].distance < pairs[i].distance + distance) ++j;
    if (j == pairs.size()) break;
    const YawTransform to_truth = AlignFirstPose(pairs[i].estimate, pairs[i].truth);
    errors.push_back((to_truth * pairs[j].estimate.p - pairs[j].truth.p).norm());
  }
  return errors;
}

double QuantileOfSorted(const std::vector<double>& sorted, double q) {
  return sorted.empty() ? std::nan("") : sorted[static_cast<size_t>(q * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

CsvTable DistanceTable(int /*trial*/, const std::filesystem::path& data) {
  CsvTable table("recording,policy,path_m,share,distance_m,segments,q05,q25,q50,q75,q95");
  for (const std::string name : {"simulated", "euroc_v1_01_easy", "tango_walk"}) {
    const Recording recording = name == "simulated" ? SimulatedOdometryRecording() : ReadRecording(data / name);
    for (auto&& policy : AllPolicies()) {
      const OdometryRun run = RunOdometry(recording, EstimatorOptions{recording.calibration}, std::move(policy));
      const std::vector<Pair> pairs = PairsOf(run.states, recording.truth);
      const double path = pairs.back().distance;
      for (const double share : {0.01, 0.02, 0.05, 0.1, 0.2}) {
        std::vector<double> errors = RelativeErrors(pairs, share * path);
        std::sort(errors.begin(), errors.end());
        table.Row(name, run.policy, path, share, share * path, errors.size(), QuantileOfSorted(errors, 0.05),
                  QuantileOfSorted(errors, 0.25), QuantileOfSorted(errors, 0.5), QuantileOfSorted(errors, 0.75),
                  QuantileOfSorted(errors, 0.95));
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
      OkvisOptions okvis;
      okvis.keyframes = keyframes;
      okvis.temporal_frames = temporal;
      const OdometryRun run = RunOdometry(recording, EstimatorOptions{recording.calibration}, MakeOkvisPolicy(okvis));
      table.Row(real ? "euroc_v1_01_easy" : "simulated", trial, keyframes, temporal,
                run.error ? run.error->position_rmse : std::nan(""), run.restarts, run.milliseconds);
    }
  }
  return table;
}

}  // namespace ch5
