#include "ch5_backend/experiments/studies/odometry_study.h"

#include <cmath>
#include <limits>
#include <map>
#include <regex>
#include <set>

#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/files/tables/trajectory_file.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr int kSnapshots = 4;  // per policy

WindowMatrices TakeSnapshot(const Window& window, double t) {
  WindowMatrices snapshot;
  snapshot.t = t;
  snapshot.H = DenseHessian(window.graph);
  snapshot.pose_rows = MakeOrdering(window.graph).dim_poses;
  const MatXX& J = window.prior->GetPrior().J;
  snapshot.H_prior = J.transpose() * J;
  return snapshot;
}

CsvTable PolicyTable(const OdometryStudy& study) {
  CsvTable table(
      "policy,ate_m,scale_error,yaw_error_deg,rotation_error_deg,realtime_factor,tracking_factor,p99_window_ms,frames,"
      "restarts,rpe_m,path_m,drift_percent");
  for (const OdometryRun& run : study.runs) {
    const auto degrees = [](double radians) { return radians * 180.0 / M_PI; };
    table.Row(run.policy, run.error ? run.error->position_rmse : kNoNumber,
              run.error ? run.error->scale - 1.0 : kNoNumber, run.error ? degrees(run.error->yaw_rmse) : kNoNumber,
              run.error ? degrees(run.error->rotation_rmse) : kNoNumber, run.realtime_factor, run.tracking_factor,
              run.p99_window_ms, run.states.size(), run.restarts,
              run.relative ? run.relative->position_rmse : kNoNumber, run.relative ? run.relative->path : kNoNumber,
              run.relative ? run.relative->DriftPercent() : kNoNumber);
  }
  return table;
}

CsvTable SegmentTable(const OdometryStudy& study) {
  CsvTable table("policy,segment,first_s,last_s,frames,ate_m,scale_error,yaw_error_deg");
  for (const OdometryRun& run : study.runs) {
    for (const OdometrySegment& segment : run.segments) {
      const auto& error = segment.error;
      table.Row(run.policy, segment.id, segment.states.front().t, segment.states.back().t, segment.states.size(),
                error ? error->position_rmse : kNoNumber, error ? error->scale - 1.0 : kNoNumber,
                error ? error->yaw_rmse * 180.0 / M_PI : kNoNumber);
    }
  }
  return table;
}

// Estimates are aligned with the truth, each segment by itself.
CsvTable PathTable(const OdometryStudy& study) {
  CsvTable table("policy,segment,t_s,x_m,y_m,z_m,error_m");
  for (const StampedState& state : study.recording.truth) {
    const Vec3& p = state.T_W_B.p;
    table.Row("truth", 0, state.t, p.x(), p.y(), p.z(), 0.0);
  }
  for (const OdometryRun& run : study.runs) {
    for (const OdometrySegment& segment : run.segments) {
      const YawTransform to_truth = segment.error ? segment.error->alignment : YawTransform{};
      for (const StampedState& state : segment.states) {
        const Vec3 p = to_truth * state.T_W_B.p;
        const auto truth = StateAt(study.recording.truth, state.t);
        table.Row(run.policy, segment.id, state.t, p.x(), p.y(), p.z(),
                  truth ? (p - truth->T_W_B.p).norm() : kNoNumber);
      }
    }
  }
  return table;
}

CsvTable WindowTable(const OdometryStudy& study) {
  CsvTable table("policy,t_s,milliseconds,status,landmarks,iterations,initial_cost,final_cost");
  for (const OdometryRun& run : study.runs) {
    for (const ImageResult& row : run.rows) {
      const char* names[] = {"starting", "tracking", "restarted"};
      const FrameReport& report = row.report;
      table.Row(run.policy, row.t, 1e3 * row.seconds, names[static_cast<int>(report.status)], report.landmarks,
                report.solve.iterations, report.solve.initial_cost, report.solve.final_cost);
    }
  }
  return table;
}

CsvTable GaugeTable(const OdometryStudy& study) {
  CsvTable table("policy,t_s,direction,information,relative");
  for (size_t r = 0; r < study.runs.size(); ++r) {
    for (const PriorAudit& audit : study.audits[r]) {
      for (const GaugeLeak& leak : audit.leaks) {
        table.Row(study.runs[r].policy, audit.t, leak.direction, leak.information, leak.relative);
      }
    }
  }
  return table;
}

CsvTable WarningTable(const OdometryStudy& study) {
  CsvTable table("warning,value,other");
  for (const RecordingWarning& warning : study.warnings) table.Row(warning.name, warning.value, warning.other);
  return table;
}

}  // namespace

Recording SimulatedOdometryRecording(uint64_t seed) {
  HandheldOptions path;
  path.duration = 20.0;
  path.standstill_seconds = 2.0;
  path.seed = seed;
  SimulationOptions options;
  options.imu.seed = seed;
  options.camera.seed = seed + 1;
  options.camera.max_tracks = 40;
  options.camera.outlier_fraction = 0.02;
  return SimulateInRoom(path, 1000, options, seed);
}

OdometryStudy RunOdometryStudy(Recording recording, const std::function<void(const std::string&, double)>& progress,
                               const OdometrySettings& settings, bool batch) {
  OdometryStudy study;
  study.recording = std::move(recording);
  const auto& frames = study.recording.images;
  const EstimatorOptions options = settings.Estimator(study.recording.calibration);
  for (auto&& policy : settings.Policies()) {
    std::vector<WindowMatrices> snapshots;
    std::vector<PriorAudit> audits;
    const std::string name = policy->Name();
    size_t image = 0;
    const auto watch = [&](const Estimator& estimator, const ImageResult& row) {
      ++image;
      if (progress) progress(name, static_cast<double>(image) / static_cast<double>(frames.size()));
      const Window& window = estimator.GetWindow();
      if (row.report.state && window.prior) {
        GaugeOptions gauge;
        gauge.local_poses = window.LocalPoses();
        audits.push_back({row.t, AuditPrior(window.prior->GetPrior(), gauge)});
      }
      // Snapshots are spread over the second half, the last one at the end.
      const size_t due = frames.size() / 2 + (snapshots.size() + 1) * frames.size() / (2 * kSnapshots);
      if (snapshots.size() < kSnapshots && row.report.state && window.prior && image + 1 >= due) {
        snapshots.push_back(TakeSnapshot(window, row.t));
      }
    };
    study.runs.push_back(RunOdometry(study.recording, options, std::move(policy), watch));
    study.snapshots.push_back(std::move(snapshots));
    study.audits.push_back(std::move(audits));
  }
  if (!batch) return study;
  if (progress) progress("batch", 0.0);
  if (auto run = RunBatch(study.recording, options, study.runs.front(), 1)) {
    study.runs.push_back(std::move(*run));
    study.snapshots.emplace_back();
    study.audits.emplace_back();
  }
  return study;
}

void WriteOdometryTables(const OdometryStudy& study, const std::filesystem::path& csv) {
  CsvTable matrices("policy,picture,t_s,stage,size,pose_rows,row,column,value");
  CsvTable spectrum("policy,t_s,index,eigenvalue,scaled");
  for (size_t r = 0; r < study.runs.size(); ++r) {
    const std::string& policy = study.runs[r].policy;
    for (size_t k = 0; k < study.snapshots[r].size(); ++k) {
      const WindowMatrices& snapshot = study.snapshots[r][k];
      AppendNonZeros(snapshot.H, &matrices, policy, k, snapshot.t, "window", snapshot.H.rows(), snapshot.pose_rows);
      AppendNonZeros(snapshot.H_prior, &matrices, policy, k, snapshot.t, "prior", snapshot.H_prior.rows(),
                     snapshot.H_prior.rows());
      const VecX p_inverse = ScalingOf(snapshot.H_prior).cwiseInverse();
      const VecX eigenvalues = Eigenvalues(snapshot.H_prior);
      const VecX scaled = Eigenvalues(p_inverse.asDiagonal() * snapshot.H_prior * p_inverse.asDiagonal());
      for (int i = 0; i < eigenvalues.size(); ++i) spectrum.Row(policy, snapshot.t, i, eigenvalues[i], scaled[i]);
    }
  }
  FileBatch files;
  files.Add(csv / "odometry_policies.csv", PolicyTable(study).Text());
  files.Add(csv / "odometry_segments.csv", SegmentTable(study).Text());
  files.Add(csv / "odometry_path.csv", PathTable(study).Text());
  files.Add(csv / "odometry_windows.csv", WindowTable(study).Text());
  files.Add(csv / "odometry_matrices.csv", matrices.Text());
  files.Add(csv / "odometry_spectrum.csv", spectrum.Text());
  files.Add(csv / "odometry_gauge.csv", GaugeTable(study).Text());
  files.Add(csv / "odometry_warnings.csv", WarningTable(study).Text());
  files.Commit();
}

namespace {

// Those that an earlier run has left in the folder.
void RemoveOlderTrajectories(const std::set<std::filesystem::path>& names, const std::filesystem::path& out) {
  static const std::regex kTrajectory(R"((vins|okvis|batch)(_\d+)?\.(tum|csv))");
  for (const auto& entry : std::filesystem::directory_iterator(out)) {
    const bool is_ours = std::regex_match(entry.path().filename().string(), kTrajectory);
    if (is_ours && names.count(entry.path().stem()) == 0) std::filesystem::remove(entry.path());
  }
}

}  // namespace

void WriteOdometryTrajectories(const OdometryStudy& study, const std::filesystem::path& out) {
  FileBatch files;
  std::set<std::filesystem::path> names;
  for (const OdometryRun& run : study.runs) {
    std::map<int, std::vector<StampedState>> segments{{0, {}}};  // the first file is there, though it be empty
    for (const OdometrySegment& segment : run.segments) segments[segment.id] = segment.states;
    for (const auto& [id, states] : segments) {
      const std::string name = run.policy + (id > 0 ? "_" + std::to_string(id) : "");
      files.Add(out / (name + ".tum"), FormatTum(states, study.recording.origin_ns));
      files.Add(out / (name + ".csv"), FormatEuroc(states, study.recording.origin_ns));
      names.insert(name);
    }
  }
  files.Commit();
  RemoveOlderTrajectories(names, out);
}

}  // namespace ch5
