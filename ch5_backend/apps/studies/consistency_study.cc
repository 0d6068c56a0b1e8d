#include "ch5_backend/apps/studies/consistency_study.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <map>
#include <mutex>
#include <thread>

#include "ch5_backend/apps/studies/odometry.h"
#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/math/parallel.h"
#include "ch5_backend/world/files/csv.h"
#include "ch5_backend/world/simulate/random.h"
#include "ch5_backend/world/simulate/scene_points.h"
#include "ch5_backend/world/simulate/simulation.h"

namespace ch5 {
namespace {

struct Case {
  const char* policy;
  const char* mode;
  FirstEstimates first_estimates;
  bool okvis, reuse;
};
constexpr Case kCases[] = {{"vins twice", "none", FirstEstimates::kNone, false, true},
                           {"vins", "none", FirstEstimates::kNone, false, false},
                           {"vins", "prior_only", FirstEstimates::kPriorOnly, false, false},
                           {"vins", "full", FirstEstimates::kFull, false, false},
                           {"okvis", "none", FirstEstimates::kNone, true, false},
                           {"okvis", "prior_only", FirstEstimates::kPriorOnly, true, false},
                           {"okvis", "full", FirstEstimates::kFull, true, false}};
constexpr int kNumCases = static_cast<int>(std::size(kCases));

// σ of the first state, for the prior and for who draws it. The speed is known so little since in W it tells yaw.
struct StartSigma {
  double position = 0.01;  // [m]
  double yaw = 0.05;       // [rad]
  double tilt = 0.01;      // roll and pitch [rad]
  double speed = 0.2;      // [m/s]
  double b_a = 0.02;       // [m/s²]
  double b_g = 0.002;      // [rad/s]
};

// Square root of the first state's information, over [δp, δθ, v, b_a, b_g]: yaw is about W's z axis. A start without
// place knows neither position nor yaw, nor which way it goes.
MatXX StartInformation(const StartSigma& sigma, const Qd& q_W_B, bool with_place) {
  MatXX J = MatXX::Zero(15, 15);
  if (with_place) J.diagonal().head<3>().setConstant(1.0 / sigma.position);
  const Vec3 rotation(1.0 / sigma.tilt, 1.0 / sigma.tilt, with_place ? 1.0 / sigma.yaw : 0.0);
  J.block<3, 3>(3, 3) = rotation.asDiagonal() * q_W_B.toRotationMatrix();
  if (with_place) J.diagonal().segment<3>(6).setConstant(1.0 / sigma.speed);
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

// Round and round a room, looking ahead: 3 m wide, 12 s a lap, up and down and swaying a little.
Trajectory Circle(double duration) {
  const auto formula = [](const Jet& t) {
    const Jet angle = (2.0 * M_PI / 12.0) * t;
    const Jet radius = 3.0 + 0.3 * Sin(1.3 * t);
    return Coordinates{{radius * Cos(angle), radius * Sin(angle), 0.4 * Sin(0.9 * t)},
                       angle + 0.5 * M_PI + 0.2 * Sin(0.7 * t),
                       0.1 * Sin(0.8 * t),
                       0.1 * Sin(1.1 * t)};
  };
  return Trajectory(formula, duration);
}

Recording Simulate(const ConsistencyOptions& options, int run) {
  Random scene(3);
  SimulationOptions simulation;
  simulation.calibration.camera_rate = options.frame_rate;
  simulation.calibration.imu_rate = 100.0;
  simulation.camera.pixel_sigma = options.pixel_sigma;
  simulation.camera.max_tracks = options.max_tracks;
  simulation.camera.drop_probability = options.lose_track;
  simulation.imu.seed = 1000 + static_cast<uint64_t>(run);
  simulation.camera.seed = 2000 + static_cast<uint64_t>(run);
  return SimulateRecording(Circle(options.seconds), PointsOnPlanes(RoomWalls({-6, -6, -3}, {6, 6, 3}), 600, &scene),
                           simulation);
}

Estimator MakeEstimator(const Case& c, const Calibration& calibration, const ConsistencyOptions& study) {
  EstimatorOptions options = OptionsFor(calibration);
  options.weights.pixel_sigma = study.pixel_sigma;
  options.weights.cauchy = 0.0;
  options.weights.noisy_hosts = !c.reuse;
  options.max_outlier_pixels = 5.0 * study.pixel_sigma;  // there are none but depths gone wrong
  options.max_rejecting = 1e9;                           // nor do so few landmarks mean anything
  options.first_estimates = c.first_estimates;
  options.report_covariance = true;
  VinsOptions vins;
  vins.window_size = 6;
  vins.reuse_observations = c.reuse;
  OkvisOptions okvis;
  okvis.keyframes = 3;
  okvis.temporal_frames = 4;
  for (double* tolerance : {&vins.cost_tolerance, &okvis.cost_tolerance}) *tolerance = 1e-6;
  vins.max_iterations = okvis.max_iterations = 20;
  vins.max_solve_seconds = 1e3;  // a result must not depend on the machine
  return Estimator(options, c.okvis ? MakeOkvisPolicy(okvis) : MakeVinsPolicy(vins));
}

// The error of one answer, and what was claimed of it.
ConsistencyRow Judge(const StampedState& state, const Mat66& covariance, const StampedState& truth) {
  const Transform& T = state.T_W_B;
  Vec6 e;
  e << T.p - truth.T_W_B.p, LogSO3(truth.T_W_B.q.conjugate() * T.q);
  const Vec3 up = T.q.conjugate() * Vec3::UnitZ();
  const double yaw = up.dot(e.tail<3>()), yaw_variance = up.dot(covariance.bottomRightCorner<3, 3>() * up);
  ConsistencyRow row;
  row.t = state.t;
  row.nees_pose = e.dot(Eigen::LDLT<Mat66>(covariance).solve(e));
  row.nees_yaw = yaw * yaw / yaw_variance;
  row.yaw_information = 1.0 / yaw_variance;
  row.yaw_rmse = yaw * yaw;  // squares, until they are averaged
  row.position_rmse = e.head<3>().squaredNorm();
  return row;
}

using RunRows = std::vector<ConsistencyRow>;

// @return  as many rows as images were answered before the estimator lost its way, if it did
RunRows RunOnce(const Recording& recording, const Case& c, const ConsistencyOptions& options, int run) {
  const StartSigma sigma;
  Random random(3000 + static_cast<uint64_t>(run));
  const StampedState first = DrawStart(recording.truth.front(), sigma, &random);
  Estimator with_place = MakeEstimator(c, recording.calibration, options);
  with_place.StartFrom(first, StartInformation(sigma, first.T_W_B.q, true));
  RunRows rows;
  FeedRecording(recording, &with_place, [&](const Estimator& estimator, const WindowRow& row) {
    if (estimator.Restarts() > 0) return;
    rows.push_back(Judge(*row.report.state, *row.report.pose_covariance, *StateAt(recording.truth, row.t)));
    rows.back().runs = 1;
  });
  if (run >= options.audited_runs) return rows;

  Estimator without_place = MakeEstimator(c, recording.calibration, options);
  without_place.StartFrom(first, StartInformation(sigma, first.T_W_B.q, false));
  size_t k = 0;
  FeedRecording(recording, &without_place, [&](const Estimator& estimator, const WindowRow&) {
    if (estimator.Restarts() > 0 || k == rows.size()) return;
    for (const GaugeLeak& leak : AuditPrior(estimator.GetWindow().prior->GetPrior())) {
      (leak.direction == "yaw" ? rows[k].yaw_leak : rows[k].position_leak) += leak.information;
    }
    ++k;
  });
  return rows;
}

// One row a time.
RunRows MeanOver(const std::vector<RunRows>& runs, const Case& c, int audited_runs) {
  RunRows means;
  for (size_t k = 0; k < runs.front().size(); ++k) {
    ConsistencyRow mean;
    mean.policy = c.policy;
    mean.mode = c.mode;
    mean.t = runs.front()[k].t;
    for (const RunRows& run : runs) mean.runs += k < run.size();
    for (double ConsistencyRow::*value :
         {&ConsistencyRow::nees_pose, &ConsistencyRow::nees_yaw, &ConsistencyRow::yaw_information,
          &ConsistencyRow::yaw_rmse, &ConsistencyRow::position_rmse}) {
      for (const RunRows& run : runs) {
        if (k < run.size()) mean.*value += run[k].*value / mean.runs;
      }
    }
    for (const RunRows& run : runs) {
      if (k >= run.size()) continue;
      mean.yaw_leak += run[k].yaw_leak / audited_runs;
      mean.position_leak += run[k].position_leak / audited_runs;
    }
    mean.yaw_rmse = std::sqrt(mean.yaw_rmse);
    mean.position_rmse = std::sqrt(mean.position_rmse);
    means.push_back(mean);
  }
  return means;
}

}  // namespace

Band ChiSquaredBand(int dof, int runs, double normal_quantile) {
  const double k = static_cast<double>(dof) * runs, s = 2.0 / (9.0 * k);
  const auto quantile = [&](double z) { return k * std::pow(1.0 - s + z * std::sqrt(s), 3) / runs; };
  return {quantile(-normal_quantile), quantile(normal_quantile)};
}

std::vector<ConsistencyRow> RunConsistencyStudy(const ConsistencyOptions& options,
                                                const std::function<void(double)>& progress) {
  std::vector<std::vector<RunRows>> results(kNumCases, std::vector<RunRows>(static_cast<size_t>(options.runs)));
  std::mutex mutex;
  int done = 0;
  ThreadPool pool(options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency()));
  pool.Run(options.runs, [&](int run) {
    const Recording recording = Simulate(options, run);
    for (size_t c = 0; c < kNumCases; ++c) {
      results[c][static_cast<size_t>(run)] = RunOnce(recording, kCases[c], options, run);
    }
    const std::lock_guard lock(mutex);
    if (progress) progress(static_cast<double>(++done) / options.runs);
  });
  std::vector<ConsistencyRow> rows;
  for (size_t c = 0; c < kNumCases; ++c) {
    const RunRows means = MeanOver(results[c], kCases[c], std::min(options.audited_runs, options.runs));
    rows.insert(rows.end(), means.begin(), means.end());
  }
  return rows;
}

void WriteConsistencyTables(const std::vector<ConsistencyRow>& rows, const std::filesystem::path& csv) {
  CsvTable table(
      "policy,mode,t_s,runs,nees_pose,pose_low,pose_high,nees_yaw,yaw_low,yaw_high,yaw_information,yaw_rmse_rad,"
      "position_rmse_m,yaw_leak,position_leak");
  CsvTable summary(
      "policy,mode,runs,nees_pose,nees_yaw,pose_inside,pose_above,yaw_inside,yaw_above,yaw_information_gain,yaw_leak,"
      "position_leak,yaw_rmse_rad,position_rmse_m");
  for (const Case& c : kCases) {
    int count = 0, pose_inside = 0, pose_above = 0, yaw_inside = 0, yaw_above = 0;
    double nees_pose = 0.0, nees_yaw = 0.0, first = 0.0, largest = 0.0;
    const ConsistencyRow* last = nullptr;
    for (const ConsistencyRow& row : rows) {
      if (row.policy != c.policy || row.mode != c.mode) continue;
      const Band pose = ChiSquaredBand(6, row.runs), yaw = ChiSquaredBand(1, row.runs);
      table.Row(row.policy, row.mode, row.t, row.runs, row.nees_pose, pose.low, pose.high, row.nees_yaw, yaw.low,
                yaw.high, row.yaw_information, row.yaw_rmse, row.position_rmse, row.yaw_leak, row.position_leak);
      if (count++ == 0) first = row.yaw_information;
      pose_inside += row.nees_pose >= pose.low && row.nees_pose <= pose.high;
      pose_above += row.nees_pose > pose.high;
      yaw_inside += row.nees_yaw >= yaw.low && row.nees_yaw <= yaw.high;
      yaw_above += row.nees_yaw > yaw.high;
      nees_pose += row.nees_pose;
      nees_yaw += row.nees_yaw;
      largest = std::max(largest, row.yaw_information);
      last = &row;
    }
    if (!last) continue;
    const double n = count;
    summary.Row(c.policy, c.mode, last->runs, nees_pose / n, nees_yaw / n, pose_inside / n, pose_above / n,
                yaw_inside / n, yaw_above / n, largest / first, last->yaw_leak, last->position_leak, last->yaw_rmse,
                last->position_rmse);
  }
  table.Write(csv / "consistency.csv");
  summary.Write(csv / "consistency_summary.csv");
}

}  // namespace ch5
