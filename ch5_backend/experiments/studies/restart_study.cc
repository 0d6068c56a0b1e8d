// A flight whose IMU is silent for two seconds: the estimator restarts, and its poses are two segments. What one alignment
// over both makes of them is beside it.
#include <algorithm>

#include "ch5_backend/experiments/studies/chapter_studies.h"
#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/files/tables/text_writer.h"

namespace ch5 {
namespace {

constexpr double kSilentFrom = 10.0, kSilentUntil = 12.0;  // [s]

Recording FlightWithSilentImu() {
  Recording recording = SimulatedOdometryRecording();
  auto& imu = recording.imu;
  imu.erase(std::remove_if(imu.begin(), imu.end(),
                           [](const ImuMeasurement& one) { return kSilentFrom < one.t && one.t < kSilentUntil; }),
            imu.end());
  return recording;
}

void AppendSegments(const OdometryRun& run, const Recording& recording, CsvTable* table) {
  const auto joint = CompareTrajectories(run.states, recording.truth);
  for (const OdometrySegment& segment : run.segments) {
    if (!segment.error) continue;
    for (const StampedState& state : segment.states) {
      const auto truth = StateAt(recording.truth, state.t);
      if (!truth) continue;
      const Vec3 p = segment.error->alignment * state.T_W_B.p;
      table->Row(run.policy, state.t, segment.id, p.x(), p.y(), (p - truth->T_W_B.p).norm(),
                 (joint->alignment * state.T_W_B.p - truth->T_W_B.p).norm());
    }
  }
}

}  // namespace

void RunRestartStudy(const std::filesystem::path& csv) {
  CsvTable table("policy,t_s,segment,x_m,y_m,error_m,joint_error_m");
  const Recording recording = FlightWithSilentImu();
  for (const Image& image : recording.images) {
    const auto truth = StateAt(recording.truth, image.t);
    if (truth) table.Row("truth", image.t, 0, truth->T_W_B.p.x(), truth->T_W_B.p.y(), 0.0, 0.0);
  }
  for (auto&& policy : AllPolicies()) {
    AppendSegments(RunOdometry(recording, EstimatorOptions{recording.calibration}, std::move(policy)), recording,
                   &table);
  }
  FileBatch files;
  files.Add(csv / "restart.csv", table.Text());
  files.Commit();
}

}  // namespace ch5
