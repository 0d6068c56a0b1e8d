#include "ch5_backend/apps/studies/consistency_study.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <mutex>
#include <thread>

#include "ch5_backend/math/parallel.h"
#include "ch5_backend/world/csv.h"
#include "ch5_backend/world/paths.h"
#include "ch5_backend/world/scene_points.h"
#include "ch5_backend/world/simulation.h"

namespace ch5 {
namespace {

struct NamedPolicy {
  const char* name;
  ConsistencyPolicy policy;
};

constexpr NamedPolicy kPolicies[] = {{"vins", {FirstEstimates::kNone, true}},
                                     {"none", {FirstEstimates::kNone, false}},
                                     {"prior_only", {FirstEstimates::kPriorOnly, false}},
                                     {"full", {FirstEstimates::kFull, false}}};

// Square root of the first state's information, over [δp, δθ, v, b_a, b_g]: yaw is about W's z axis.
MatXX StartInformation(const StartSigma& sigma, const Qd& q_W_B) {
  MatXX J = MatXX::Zero(15, 15);
  J.diagonal().head<3>().setConstant(1.0 / sigma.position);
  const Vec3 rotation(1.0 / sigma.tilt, 1.0 / sigma.tilt, 1.0 / sigma.yaw);
  J.block<3, 3>(3, 3) = rotation.asDiagonal() * q_W_B.toRotationMatrix();
  J.diagonal().segment<3>(6).setConstant(1.0 / sigma.speed);
  J.diagonal().segment<3>(9).setConstant(1.0 / sigma.b_a);
  J.diagonal().segment<3>(12).setConstant(1.0 / sigma.b_g);
  return J;
}

StampedState DrawStart(StampedState state, const StartSigma& sigma, Random* random) {
  state.T_W_B.p += NormalVector(random, sigma.position);
  const Vec3 tilt = NormalVector(random, sigma.tilt);
  const double yaw = sigma.yaw * random->Normal();
  state.T_W_B.q = ExpSO3(Vec3(tilt.x(), tilt.y(), yaw)) * state.T_W_B.q;
  state.v_W += NormalVector(random, sigma.speed);
  state.b_a += NormalVector(random, sigma.b_a);
  state.b_g += NormalVector(random, sigma.b_g);
  return state;
}

Recording Simulate(const ConsistencyOptions& options, int run) {
  HandheldOptions handheld;
  handheld.duration = options.seconds;
  Random scene(3);
  SimulationOptions simulation;
  simulation.calibration.camera_rate = options.frame_rate;
  simulation.camera.pixel_sigma = options.pixel_sigma;
  simulation.camera.max_tracks = options.max_tracks;
  simulation.imu.seed = 1000 + static_cast<uint64_t>(run);
  simulation.camera.seed = 2000 + static_cast<uint64_t>(run);
  return SimulateRecording(Handheld(handheld), PointsOnPlanes(RoomWalls({-6, -6, -3}, {6, 6, 3}), 600, &scene),
                           simulation);
}

// The error of one answer, and what was claimed of it.
ConsistencyRow Judge(const WindowAnswer& answer, const StampedState& truth) {
  const Transform& T = answer.state.T_W_B;
  Vec6 e;
  e << T.p - truth.T_W_B.p, LogSO3(truth.T_W_B.q.conjugate() * T.q);
  const Vec3 up = T.q.conjugate() * Vec3::UnitZ();
  const double yaw = up.dot(e.tail<3>()), yaw_variance = up.dot(answer.pose_covariance.bottomRightCorner<3, 3>() * up);
  ConsistencyRow row;
  row.t = answer.state.t;
  row.nees_pose = e.dot(Eigen::LDLT<Mat66>(answer.pose_covariance).solve(e));
  row.nees_yaw = yaw * yaw / yaw_variance;
  row.yaw_information = 1.0 / yaw_variance;
  row.yaw_rmse = yaw * yaw;  // squares, until they are averaged
  row.position_rmse = e.head<3>().squaredNorm();
  return row;
}

std::vector<ConsistencyRow> RunOnce(const Recording& recording, const NamedPolicy& policy,
                                    const ConsistencyOptions& options, int run) {
  const StartSigma sigma;
  Random random(3000 + static_cast<uint64_t>(run));
  const StampedState first = DrawStart(recording.truth.front(), sigma, &random);
  ConsistencyWindow window(recording.calibration, options.pixel_sigma, options.window, policy.policy, first,
                           StartInformation(sigma, first.T_W_B.q));
  std::vector<ConsistencyRow> rows;
  for (size_t k = 0; k < recording.frames.size(); ++k) {
    const CameraFrame& image = recording.frames[k];
    const auto samples =
        k == 0 ? std::vector<ImuSample>() : SamplesBetween(recording.imu, recording.frames[k - 1].t, image.t);
    rows.push_back(Judge(window.AddFrame(image, samples), *StateAt(recording.truth, image.t)));
  }
  return rows;
}

}  // namespace

Band ChiSquaredBand(int dof, int runs, double normal_quantile) {
  const double k = static_cast<double>(dof) * runs, s = 2.0 / (9.0 * k);
  const auto quantile = [&](double z) { return k * std::pow(1.0 - s + z * std::sqrt(s), 3) / runs; };
  return {quantile(-normal_quantile), quantile(normal_quantile)};
}

std::vector<ConsistencyRow> RunConsistencyStudy(const ConsistencyOptions& options,
                                                const std::function<void(double)>& progress) {
  constexpr int kCount = static_cast<int>(std::size(kPolicies));
  std::vector<std::vector<ConsistencyRow>> results(static_cast<size_t>(options.runs * kCount));
  std::mutex mutex;
  int done = 0;
  ThreadPool pool(options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency()));
  pool.Run(options.runs, [&](int run) {
    const Recording recording = Simulate(options, run);
    for (int p = 0; p < kCount; ++p) {
      results[static_cast<size_t>(p * options.runs + run)] = RunOnce(recording, kPolicies[p], options, run);
    }
    const std::lock_guard lock(mutex);
    if (progress) progress(static_cast<double>(++done) / options.runs);
  });

  std::vector<ConsistencyRow> rows;
  for (int p = 0; p < kCount; ++p) {
    const auto run_of = [&](int run) { return results.begin() + p * options.runs + run; };
    for (size_t k = 0; k < run_of(0)->size(); ++k) {
      ConsistencyRow mean = (*run_of(0))[k];
      mean.policy = kPolicies[p].name;
      for (double ConsistencyRow::*value :
           {&ConsistencyRow::nees_pose, &ConsistencyRow::nees_yaw, &ConsistencyRow::yaw_information,
            &ConsistencyRow::yaw_rmse, &ConsistencyRow::position_rmse}) {
        mean.*value = 0.0;
        for (int run = 0; run < options.runs; ++run) mean.*value += (*run_of(run))[k].*value / options.runs;
      }
      mean.yaw_rmse = std::sqrt(mean.yaw_rmse);
      mean.position_rmse = std::sqrt(mean.position_rmse);
      rows.push_back(mean);
    }
  }
  return rows;
}

void WriteConsistencyTables(const std::vector<ConsistencyRow>& rows, const ConsistencyOptions& options,
                            const std::filesystem::path& csv) {
  const Band pose = ChiSquaredBand(6, options.runs), yaw = ChiSquaredBand(1, options.runs);
  CsvTable table(
      "policy,t_s,nees_pose,pose_low,pose_high,nees_yaw,yaw_low,yaw_high,yaw_information,yaw_rmse_rad,position_rmse_m");
  for (const ConsistencyRow& row : rows) {
    table.Row(row.policy, row.t, row.nees_pose, pose.low, pose.high, row.nees_yaw, yaw.low, yaw.high,
              row.yaw_information, row.yaw_rmse, row.position_rmse);
  }
  CsvTable summary("policy,runs,nees_pose,nees_yaw,pose_inside,yaw_information_gain,position_rmse_m");
  for (const NamedPolicy& policy : kPolicies) {
    int count = 0, inside = 0;
    double nees_pose = 0.0, nees_yaw = 0.0, first = 0.0, largest = 0.0, squares = 0.0;
    for (const ConsistencyRow& row : rows) {
      if (row.policy != policy.name) continue;
      if (count++ == 0) first = row.yaw_information;
      inside += row.nees_pose >= pose.low && row.nees_pose <= pose.high;
      nees_pose += row.nees_pose;
      nees_yaw += row.nees_yaw;
      largest = std::max(largest, row.yaw_information);
      squares += row.position_rmse * row.position_rmse;
    }
    summary.Row(policy.name, options.runs, nees_pose / count, nees_yaw / count, static_cast<double>(inside) / count,
                largest / first, std::sqrt(squares / count));
  }
  table.Write(csv / "consistency.csv");
  summary.Write(csv / "consistency_summary.csv");
}

}  // namespace ch5
