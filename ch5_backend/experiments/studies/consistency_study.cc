#include "ch5_backend/experiments/studies/consistency_study.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <thread>

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/evaluate/nees.h"
#include "ch5_backend/files/tables/csv.h"
#include "ch5_backend/math/parallel.h"

namespace ch5 {
namespace {

std::vector<ConsistencyCase> AllCases() {
  std::vector<ConsistencyCase> cases;
  for (const char* hosts : {"exact", "noisy"}) cases.push_back({"vins", "twice", hosts, "none"});
  for (const char* policy : {"vins", "okvis"}) {
    for (const char* hosts : {"exact", "noisy"}) {
      for (const char* mode : {"none", "prior_only", "full"}) cases.push_back({policy, "once", hosts, mode});
    }
  }
  return cases;
}

bool SameCase(const ConsistencyCase& a, const ConsistencyCase& b) {
  return a.policy == b.policy && a.observations == b.observations && a.hosts == b.hosts && a.mode == b.mode;
}

// One image of one run.
struct Sample {
  double t = 0.0;
  PoseConsistency pose;
  double yaw_leak = 0.0, position_leak = 0.0;  // of the repetition without position and yaw
};
using Run = std::vector<Sample>;

// @return  a sample per image until the estimator restarts, if it does
Run RunOnce(const Recording& recording, const ConsistencyCase& c, const ConsistencyOptions& options, int run) {
  const DrawnStart start = DrawStart(recording.truth.front(), run);
  const EstimatorOptions settings = ConsistencyEstimator(c, recording.calibration, options);
  Estimator estimator(settings, ConsistencyPolicy(c));
  estimator.StartFrom(start.state, start.J);
  Run samples;
  FeedRecording(recording, &estimator, [&](const Estimator& now, const ImageResult& row) {
    if (now.Restarts() > 0) return;
    const StampedState truth = *StateAt(recording.truth, row.t);
    samples.push_back(
        {row.t, ComparePose(row.report.state->T_W_B, row.report.covariance->Pose(), truth.T_W_B), 0.0, 0.0});
  });
  if (run >= options.audited_runs) return samples;

  Estimator free(settings, ConsistencyPolicy(c));
  free.StartFrom(start.state, start.J_free);
  size_t k = 0;
  FeedRecording(recording, &free, [&](const Estimator& now, const ImageResult&) {
    if (now.Restarts() > 0 || k == samples.size()) return;
    for (const GaugeLeak& leak : AuditPrior(now.GetWindow().prior->GetPrior())) {
      (leak.direction == "yaw" ? samples[k].yaw_leak : samples[k].position_leak) += leak.information;
    }
    ++k;
  });
  return samples;
}

// Over the runs that reached image k.
ConsistencyRow MeanAt(size_t k, const std::vector<Run>& runs, const ConsistencyCase& c, int audited_runs) {
  ConsistencyRow row;
  static_cast<ConsistencyCase&>(row) = c;
  row.t = runs.front()[k].t;
  for (const Run& run : runs) row.runs += k < run.size();
  double squared_yaw_error = 0.0, squared_position_error = 0.0;  // means
  for (const Run& run : runs) {
    if (k >= run.size()) continue;
    const PoseConsistency& pose = run[k].pose;
    row.nees_pose += pose.nees / row.runs;
    row.nees_yaw += pose.YawNees() / row.runs;
    row.yaw_information += 1.0 / pose.yaw_variance / row.runs;
    squared_yaw_error += pose.yaw_error * pose.yaw_error / row.runs;
    squared_position_error += pose.error.head<3>().squaredNorm() / row.runs;
    row.yaw_leak += run[k].yaw_leak / audited_runs;
    row.position_leak += run[k].position_leak / audited_runs;
  }
  row.yaw_rmse = std::sqrt(squared_yaw_error);
  row.position_rmse = std::sqrt(squared_position_error);
  return row;
}

ConsistencyRun MeanOf(const Run& run, const ConsistencyCase& c) {
  ConsistencyRun mean;
  static_cast<ConsistencyCase&>(mean) = c;
  for (const Sample& sample : run) {
    mean.nees_pose += sample.pose.nees / static_cast<double>(run.size());
    mean.nees_yaw += sample.pose.YawNees() / static_cast<double>(run.size());
  }
  return mean;
}

}  // namespace

ConsistencyStudy RunConsistencyStudy(const ConsistencyOptions& options, const std::function<void(double)>& progress) {
  const std::vector<ConsistencyCase> cases = AllCases();
  std::vector<std::vector<Run>> results(cases.size(), std::vector<Run>(static_cast<size_t>(options.runs)));
  std::mutex mutex;
  int done = 0;
  ThreadPool pool(options.threads > 0 ? options.threads
                                      : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  pool.Run(options.runs, [&](int run) {
    const Recording recording = ConsistencyFlight(options, run);
    for (size_t c = 0; c < cases.size(); ++c) {
      results[c][static_cast<size_t>(run)] = RunOnce(recording, cases[c], options, run);
    }
    const std::lock_guard lock(mutex);
    if (progress) progress(static_cast<double>(++done) / options.runs);
  });
  ConsistencyStudy study;
  for (size_t c = 0; c < cases.size(); ++c) {
    for (size_t k = 0; k < results[c].front().size(); ++k) {
      study.rows.push_back(MeanAt(k, results[c], cases[c], std::min(options.audited_runs, options.runs)));
    }
    for (const Run& run : results[c]) study.runs.push_back(MeanOf(run, cases[c]));
  }
  return study;
}

namespace {

// Standard error of the mean of independent values.
double StandardError(const std::vector<double>& values) {
  const auto v = Eigen::Map<const VecX>(values.data(), static_cast<Eigen::Index>(values.size()));
  const double n = static_cast<double>(values.size());
  return n > 1.0 ? (v.array() - v.mean()).matrix().norm() / std::sqrt(n * (n - 1.0)) : 0.0;
}

// What consistency_summary.csv says of one case.
class CaseSummary {
 public:
  void Add(const ConsistencyRow& row, const ConfidenceBand& pose, const ConfidenceBand& yaw) {
    if (count_++ == 0) first_information_ = row.yaw_information;
    pose_inside_ += pose.Contains(row.nees_pose);
    pose_above_ += row.nees_pose > pose.high;
    yaw_inside_ += yaw.Contains(row.nees_yaw);
    yaw_above_ += row.nees_yaw > yaw.high;
    nees_pose_ += row.nees_pose;
    nees_yaw_ += row.nees_yaw;
    largest_information_ = std::max(largest_information_, row.yaw_information);
    last_ = row;
  }
  void Add(const ConsistencyRun& run) {
    run_pose_.push_back(run.nees_pose);
    run_yaw_.push_back(run.nees_yaw);
  }
  void AppendTo(CsvTable* table) const {
    if (count_ == 0) return;
    const double n = count_;
    table->Row(last_.policy, last_.observations, last_.hosts, last_.mode, last_.runs, nees_pose_ / n,
               StandardError(run_pose_), nees_yaw_ / n, StandardError(run_yaw_), pose_inside_ / n, pose_above_ / n,
               yaw_inside_ / n, yaw_above_ / n, largest_information_ / first_information_, last_.yaw_leak,
               last_.position_leak, last_.yaw_rmse, last_.position_rmse);
  }

 private:
  int count_ = 0, pose_inside_ = 0, pose_above_ = 0, yaw_inside_ = 0, yaw_above_ = 0;
  double nees_pose_ = 0.0, nees_yaw_ = 0.0;  // sums
  double first_information_ = 0.0, largest_information_ = 0.0;
  std::vector<double> run_pose_, run_yaw_;
  ConsistencyRow last_;
};

}  // namespace

void WriteConsistencyTables(const ConsistencyStudy& study, const std::filesystem::path& csv) {
  CsvTable table(
      "policy,observations,hosts,mode,t_s,runs,nees_pose,pose_low,pose_high,nees_yaw,yaw_low,yaw_high,yaw_information,"
      "yaw_rmse_rad,position_rmse_m,yaw_leak,position_leak");
  CsvTable summaries(
      "policy,observations,hosts,mode,runs,nees_pose,nees_pose_error,nees_yaw,nees_yaw_error,pose_inside,pose_above,"
      "yaw_inside,yaw_above,yaw_information_gain,yaw_leak,position_leak,yaw_rmse_rad,position_rmse_m");
  for (const ConsistencyCase& c : AllCases()) {
    CaseSummary summary;
    for (const ConsistencyRow& row : study.rows) {
      if (!SameCase(row, c)) continue;
      const ConfidenceBand pose = ChiSquaredBand(6, row.runs), yaw = ChiSquaredBand(1, row.runs);
      table.Row(row.policy, row.observations, row.hosts, row.mode, row.t, row.runs, row.nees_pose, pose.low, pose.high,
                row.nees_yaw, yaw.low, yaw.high, row.yaw_information, row.yaw_rmse, row.position_rmse, row.yaw_leak,
                row.position_leak);
      summary.Add(row, pose, yaw);
    }
    for (const ConsistencyRun& run : study.runs) {
      if (SameCase(run, c)) summary.Add(run);
    }
    summary.AppendTo(&summaries);
  }
  table.Write(csv / "consistency.csv");
  summaries.Write(csv / "consistency_summary.csv");
}

}  // namespace ch5
