#include "ch5_backend/experiments/studies/consistency_study.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/math/parallel.h"

namespace ch5 {
namespace {

constexpr int kAuditedRuns = 2;  // are repeated without position and yaw

std::vector<ConsistencyResult> AllCases() {
  std::vector<ConsistencyResult> cases;
  const auto add = [&](const ConsistencyCase& c) { cases.push_back({c, {}, {}, {}}); };
  for (const char* hosts : {"exact", "noisy", "published"}) add({"vins", "twice", hosts, "none"});
  add({"vins", "once", "published", "none"});
  for (const char* policy : {"vins", "okvis"}) {
    for (const char* hosts : {"exact", "noisy"}) {
      for (const char* mode : {"none", "prior_only", "full"}) add({policy, "once", hosts, mode});
    }
  }
  return cases;
}

// One image of one run.
struct Sample {
  double t = 0.0;
  PoseConsistency pose;
  std::optional<std::pair<double, double>> leak;  // into yaw and position, of the repetition without them
};
using Run = std::vector<Sample>;

// @return  a sample per image until the estimator restarts, if it does
Run RunOnce(const Recording& recording, const ConsistencyCase& c, int run) {
  const DrawnStart start = DrawStart(recording.truth.front(), run);
  const EstimatorOptions settings = ConsistencyEstimator(c, recording.calibration);
  Estimator estimator(settings, ConsistencyPolicy(c));
  estimator.StartFrom(start.state, start.J);
  Run samples;
  FeedRecording(recording, &estimator, [&](const Estimator& now, const ImageResult& row) {
    if (now.Restarts() > 0) return;
    const StampedState truth = *StateAt(recording.truth, row.t);
    samples.push_back({row.t, ComparePose(row.report.state->T_W_B, row.report.covariance->Pose(), truth.T_W_B), {}});
  });
  if (run >= kAuditedRuns) return samples;

  Estimator free(settings, ConsistencyPolicy(c));
  free.StartFrom(start.state, start.J_free);
  size_t k = 0;
  FeedRecording(recording, &free, [&](const Estimator& now, const ImageResult&) {
    if (now.Restarts() > 0 || k == samples.size()) return;
    auto& sum = samples[k++].leak.emplace();
    for (const GaugeLeak& leak : AuditPrior(now.GetWindow().prior->GetPrior())) {
      (leak.direction == "yaw" ? sum.first : sum.second) += leak.information;
    }
  });
  return samples;
}

// Over the runs that reached image k.
ConsistencyRow MeanAt(size_t k, const std::vector<Run>& runs) {
  ConsistencyRow row;
  row.t = runs.front()[k].t;
  int audited = 0;
  for (const Run& run : runs) {
    row.runs += k < run.size();
    audited += k < run.size() && run[k].leak;
  }
  double squared_yaw_error = 0.0, squared_position_error = 0.0;  // means
  for (const Run& run : runs) {
    if (k >= run.size()) continue;
    const PoseConsistency& pose = run[k].pose;
    row.nees_pose += pose.nees / row.runs;
    row.nees_yaw += pose.YawNees() / row.runs;
    row.yaw_information += 1.0 / pose.yaw_variance / row.runs;
    squared_yaw_error += pose.yaw_error * pose.yaw_error / row.runs;
    squared_position_error += pose.error.head<3>().squaredNorm() / row.runs;
    if (!run[k].leak) continue;
    row.yaw_leak += run[k].leak->first;
    row.position_leak += run[k].leak->second;
  }
  row.yaw_leak /= audited;  // NaN if there is none
  row.position_leak /= audited;
  row.yaw_rmse = std::sqrt(squared_yaw_error);
  row.position_rmse = std::sqrt(squared_position_error);
  row.pose_band = ChiSquaredBand(6, row.runs);
  row.yaw_band = ChiSquaredBand(1, row.runs);
  return row;
}

void Summarize(const std::vector<Run>& runs, ConsistencyResult* result) {
  for (size_t k = 0; k < runs.front().size(); ++k) result->rows.push_back(MeanAt(k, runs));
  for (const Run& run : runs) {
    double nees_pose = 0.0, nees_yaw = 0.0;
    for (const Sample& sample : run) {
      nees_pose += sample.pose.nees / static_cast<double>(run.size());
      nees_yaw += sample.pose.YawNees() / static_cast<double>(run.size());
    }
    result->nees_pose_of_run.push_back(nees_pose);
    result->nees_yaw_of_run.push_back(nees_yaw);
  }
}

}  // namespace

std::vector<ConsistencyResult> RunConsistencyStudy(const ConsistencyOptions& options,
                                                   const std::function<void(double)>& progress) {
  std::vector<ConsistencyResult> results = AllCases();
  std::vector<std::vector<Run>> runs(results.size(), std::vector<Run>(static_cast<size_t>(options.runs)));
  std::mutex mutex;
  int done = 0;
  ThreadPool pool(options.threads > 0 ? options.threads
                                      : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  pool.Run(options.runs, [&](int run) {
    const Recording recording = ConsistencyFlight(options, run);
    for (size_t c = 0; c < results.size(); ++c) {
      runs[c][static_cast<size_t>(run)] = RunOnce(recording, results[c], run);
    }
    const std::lock_guard lock(mutex);
    if (progress) progress(static_cast<double>(++done) / options.runs);
  });
  for (size_t c = 0; c < results.size(); ++c) Summarize(runs[c], &results[c]);
  return results;
}

namespace {

// Standard error of the mean of independent values; a single value has none.
double StandardError(const std::vector<double>& values) {
  const auto v = Eigen::Map<const VecX>(values.data(), static_cast<Eigen::Index>(values.size()));
  const double n = static_cast<double>(values.size());
  return n > 1.0 ? (v.array() - v.mean()).matrix().norm() / std::sqrt(n * (n - 1.0)) : kNoNumber;
}

}  // namespace

void WriteConsistencyTables(const std::vector<ConsistencyResult>& results, const std::filesystem::path& csv) {
  CsvTable table(
      "policy,observations,hosts,mode,t_s,runs,nees_pose,pose_low,pose_high,nees_yaw,yaw_low,yaw_high,yaw_information,"
      "yaw_rmse_rad,position_rmse_m,yaw_leak,position_leak");
  CsvTable summary(
      "policy,observations,hosts,mode,runs,nees_pose,nees_pose_error,nees_yaw,nees_yaw_error,pose_inside,pose_above,"
      "yaw_inside,yaw_above,yaw_information_gain,yaw_leak,position_leak,yaw_rmse_rad,position_rmse_m");
  for (const ConsistencyResult& c : results) {
    if (c.rows.empty()) continue;
    double nees_pose = 0.0, nees_yaw = 0.0, largest_information = 0.0;
    double pose_inside = 0.0, pose_above = 0.0, yaw_inside = 0.0, yaw_above = 0.0;
    for (const ConsistencyRow& row : c.rows) {
      table.Row(c.policy, c.observations, c.hosts, c.mode, row.t, row.runs, row.nees_pose, row.pose_band.low,
                row.pose_band.high, row.nees_yaw, row.yaw_band.low, row.yaw_band.high, row.yaw_information,
                row.yaw_rmse, row.position_rmse, row.yaw_leak, row.position_leak);
      nees_pose += row.nees_pose;
      nees_yaw += row.nees_yaw;
      largest_information = std::max(largest_information, row.yaw_information);
      pose_inside += row.pose_band.Contains(row.nees_pose);
      pose_above += row.nees_pose > row.pose_band.high;
      yaw_inside += row.yaw_band.Contains(row.nees_yaw);
      yaw_above += row.nees_yaw > row.yaw_band.high;
    }
    const auto n = static_cast<double>(c.rows.size());
    const ConsistencyRow& last = c.rows.back();
    summary.Row(c.policy, c.observations, c.hosts, c.mode, last.runs, nees_pose / n, StandardError(c.nees_pose_of_run),
                nees_yaw / n, StandardError(c.nees_yaw_of_run), pose_inside / n, pose_above / n, yaw_inside / n,
                yaw_above / n, largest_information / c.rows.front().yaw_information, last.yaw_leak, last.position_leak,
                last.yaw_rmse, last.position_rmse);
  }
  table.Write(csv / "consistency.csv");
  summary.Write(csv / "consistency_summary.csv");
}

}  // namespace ch5
