#include "ch5_backend/experiments/studies/odometry_study.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <regex>
#include <set>
#include <utility>

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/experiments/studies/matrices.h"
#include "ch5_backend/experiments/studies/motion_nees.h"
#include "ch5_backend/experiments/studies/sensor_faults.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/experiments/studies/window/wrapped_policy.h"
#include "ch5_backend/files/tables/trajectory_file.h"
#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

constexpr size_t kSpectra = 4;      // of the prior, per policy
constexpr int kComparedEvery = 10;  // windows: their motion's NEES, each as much work as some of its steps
constexpr size_t kFilmed = 32;      // images of the film

void AppendSpectrum(const std::string& policy, double t, const Window& window, CsvTable* table) {
  const MatXX& J = window.prior->GetPrior().J;
  const MatXX H = J.transpose() * J;
  const VecX p_inverse = ScalingOf(H).cwiseInverse();
  const VecX eigenvalues = Eigenvalues(H);
  const VecX scaled = Eigenvalues(p_inverse.asDiagonal() * H * p_inverse.asDiagonal());
  for (int i = 0; i < eigenvalues.size(); ++i) table->Row(policy, t, i, eigenvalues[i], scaled[i]);
}

void AppendGauge(const std::string& policy, double t, const Window& window, CsvTable* table) {
  GaugeOptions gauge;
  gauge.local_poses = window.LocalPoses();
  for (const GaugeLeak& leak : AuditPrior(window.prior->GetPrior(), gauge)) {
    table->Row(policy, t, leak.direction, leak.information, leak.relative);
  }
}

// By motion_nees.h: the newest frame against the window's oldest.
void AppendConsistency(const std::string& policy, const MotionNees& nees, CsvTable* table) {
  constexpr double kDegrees = 180.0 / M_PI;
  for (const auto& [t, pose, variances] : nees.motions)
    table->Row(policy, t, pose.error.head<3>().norm(), std::sqrt(variances.head<3>().sum()),
               kDegrees * pose.error.tail<3>().norm(), kDegrees * std::sqrt(variances.tail<3>().sum()), pose.nees);
}

// Collects how far each newest image's points lie, after the solve, from where their landmarks should be seen [px], and
// LateOfNewest.
std::unique_ptr<WindowPolicy> WithResiduals(std::unique_ptr<WindowPolicy> policy, std::vector<double>* pixels,
                                            double* late) {
  const auto watch = [=](Window* window, const std::function<void()>& slide) {
    *late = LateOfNewest(*window);
    const double focal_length = window->calibration.FocalLength();
    for (const auto& [id, landmark] : window->landmarks) {
      const WindowObservation& seen = landmark.seen.back();
      if (seen.frame != window->frames.back().id || !seen.edge || !window->graph.Contains(*seen.edge)) continue;
      seen.edge->ComputeResidual();
      for (const double r : seen.edge->Residual()) pixels->push_back(focal_length * std::abs(r));
    }
    slide();
  };
  return std::make_unique<WrappedPolicy>(std::move(policy), watch);
}

CsvTable PolicyTable(const OdometryStudy& study) {
  CsvTable table(
      "policy,ate_m,scale_error,yaw_error_deg,rotation_error_deg,realtime_factor,tracking_factor,p99_window_ms,frames,"
      "restarts,rpe_m,path_m,drift_percent,nees_motion,nees_windows");
  for (const OdometryRun& run : study.runs) {
    const auto degrees = [](double radians) { return radians * 180.0 / M_PI; };
    table.Row(run.policy, run.error ? run.error->position_rmse : kNoNumber,
              run.error ? run.error->scale - 1.0 : kNoNumber, run.error ? degrees(run.error->yaw_rmse) : kNoNumber,
              run.error ? degrees(run.error->rotation_rmse) : kNoNumber, run.realtime_factor, run.tracking_factor,
              run.p99_window_ms, run.states.size(), run.restarts,
              run.relative ? run.relative->position_rmse : kNoNumber, run.relative ? run.relative->path : kNoNumber,
              run.relative ? run.relative->DriftPercent() : kNoNumber, run.nees_motion, run.nees_windows);
  }
  return table;
}

// What else has come of a run, with its σ where there is one: the last covariance's.
CsvTable ResultTable(const OdometryStudy& study) {
  constexpr double kDegrees = 180.0 / M_PI;
  CsvTable table("policy,quantity,value,sigma");
  for (const OdometryRun& run : study.runs) {
    if (run.states.empty()) continue;
    double path = 0.0;
    for (const OdometrySegment& segment : run.segments)
      for (size_t k = 1; k < segment.states.size(); ++k)
        path += (segment.states[k].T_W_B.p - segment.states[k - 1].T_W_B.p).norm();
    table.Row(run.policy, "first_pose_s", run.states.front().t, kNoNumber);
    table.Row(run.policy, "estimated_path_m", path, kNoNumber);
    const auto variance = run.covariance ? run.covariance->time_offset_variance : std::nullopt;
    table.Row(run.policy, "time_offset_s", run.time_offset.value_or(kNoNumber),
              variance ? std::sqrt(*variance) : study.clock_sigma.value_or(kNoNumber));
    if (!run.covariance || !run.covariance->extrinsic) continue;
    const Transform& given = study.recording.calibration.T_B_C;
    Vec6 moved;  // [δp, δθ], T_B_C's increment
    moved << run.T_B_C.p - given.p, kDegrees * LogSO3(given.q.conjugate() * run.T_B_C.q);
    const char* names[] = {"x_m", "y_m", "z_m", "x_deg", "y_deg", "z_deg"};
    for (int i = 0; i < 6; ++i) {
      const double sigma = std::sqrt((*run.covariance->extrinsic)(i, i));
      table.Row(run.policy, std::string("extrinsic_moved_") + names[i], moved[i], i < 3 ? sigma : kDegrees * sigma);
    }
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

// Of each answered image its own stamp, by which tables and files can be joined; a batch has none.
std::vector<double> StampsOf(const OdometryRun& run) {
  std::vector<double> stamps;
  for (const ImageResult& row : run.rows)
    if (row.report.state) stamps.push_back(row.t);
  return stamps;
}

// Estimates are aligned with the truth, each segment by itself.
CsvTable PathTable(const OdometryStudy& study) {
  CsvTable table("policy,segment,t_s,x_m,y_m,z_m,error_m,bax_m_s2,bay_m_s2,baz_m_s2,bgx_rad_s,bgy_rad_s,bgz_rad_s");
  const auto append = [&table](const std::string& policy, int segment, double t, const Vec3& p, double error,
                               const Vec3& b_a, const Vec3& b_g) {
    table.Row(policy, segment, t, p.x(), p.y(), p.z(), error, b_a.x(), b_a.y(), b_a.z(), b_g.x(), b_g.y(), b_g.z());
  };
  const Vec3 none = Vec3::Constant(kNoNumber);
  const auto& truth = study.recording.truth;
  const bool knows_biases =  // else a recorder writes zeros
      std::any_of(truth.begin(), truth.end(),
                  [](const auto& state) { return !state.b_a.isZero() || !state.b_g.isZero(); });
  for (const StampedState& state : truth)
    append("truth", 0, state.t, state.T_W_B.p, 0.0, knows_biases ? state.b_a : none, knows_biases ? state.b_g : none);
  for (const OdometryRun& run : study.runs) {
    const std::vector<double> stamps = StampsOf(run);
    size_t image = 0;
    for (const OdometrySegment& segment : run.segments) {
      const YawTransform to_truth = segment.error ? segment.error->alignment : YawTransform{};
      for (const StampedState& state : segment.states) {
        const Vec3 p = to_truth * state.T_W_B.p;
        const auto there = segment.error ? StateAt(truth, state.t) : std::nullopt;
        append(run.policy, segment.id, stamps.empty() ? state.t : stamps[image++], p,
               there ? (p - there->T_W_B.p).norm() : kNoNumber, state.b_a, state.b_g);
      }
    }
  }
  return table;
}

// Whiskers of 5 and 95 %; without rows where no truth is.
CsvTable LengthTable(const OdometryStudy& study) {
  constexpr double kDegrees = 180.0 / M_PI;
  CsvTable table("policy,share,distance_m,pieces,quantity,q05,q25,q50,q75,q95");
  for (const OdometryRun& run : study.runs) {
    std::vector<std::vector<StampedState>> segments;
    for (const OdometrySegment& segment : run.segments) segments.push_back(segment.states);
    for (const LengthErrors& of : ErrorsOverLengths(segments, study.recording.truth, {0.02, 0.05, 0.1, 0.2, 0.4})) {
      const auto append = [&](const char* quantity, const std::vector<double>& errors, double unit) {
        const auto at = [&](double q) { return unit * QuantileOfSorted(errors, q); };
        table.Row(run.policy, of.share, of.length, errors.size(), quantity, at(0.05), at(0.25), at(0.5), at(0.75),
                  at(0.95));
      };
      append("position_m", of.position, 1.0);
      append("yaw_deg", of.yaw, kDegrees);
    }
  }
  return table;
}

CsvTable WindowTable(const OdometryStudy& study) {
  CsvTable table("policy,t_s,milliseconds,status,landmarks,iterations,initial_cost,final_cost,tracks,failure");
  std::map<double, size_t> tracks;
  for (const Image& image : study.recording.images) tracks[image.t] = image.tracks.size();
  for (const OdometryRun& run : study.runs) {
    for (const ImageResult& row : run.rows) {
      const char* names[] = {"starting", "tracking", "restarted"};
      const char* failures[] = {"none",    "accelerometer_bias", "gyroscope_bias",  "position_jump", "height_jump",
                                "imu_gap", "image_gap",          "images_rejected", "solve_failed"};
      const FrameReport& report = row.report;
      const auto solved = [&](double value) { return report.solve.trace.empty() ? kNoNumber : value; };
      table.Row(run.policy, row.t, 1e3 * row.seconds, names[static_cast<int>(report.status)], solved(report.landmarks),
                solved(report.solve.iterations), solved(report.solve.initial_cost), solved(report.solve.final_cost),
                tracks.at(row.t), failures[static_cast<int>(report.failure)]);
    }
  }
  return table;
}

CsvTable WarningTable(const OdometryStudy& study) {
  CsvTable table("warning,value,other,detail,words,t_s");
  for (const RecordingWarning& warning : study.warnings)
    table.Row(warning.name, warning.value, warning.other, warning.detail, warning.words, warning.t);
  return table;
}

// The image of the k-th spectrum: they are spread over the second half, the last one at the end.
size_t DueImage(size_t k, size_t images) { return images / 2 + (k + 1) * images / (2 * kSpectra); }

// A policy's run, and what is seen of its windows meanwhile.
void Follow(std::unique_ptr<WindowPolicy> policy, const EstimatorOptions& options, const StudyProgress& progress,
            OdometryStudy* study) {
  const Recording& recording = study->recording;
  const std::string name = policy->Name();
  const size_t images = recording.images.size();
  size_t image = 0, spectra = 0;
  std::vector<double> pixels;
  double late = kNoNumber;
  policy = WithResiduals(std::move(policy), &pixels, &late);
  MotionNees nees;
  if (!recording.truth.empty())
    policy = ComparedBeforeSlides(std::move(policy), recording.truth, kComparedEvery, &nees);
  if (study->film)
    policy = Filmed(std::move(policy), recording.truth, static_cast<int>(1 + images / kFilmed), &*study->film);
  const auto watch = [&](const Estimator& estimator, ImageResult& row) {
    row.seconds -= std::exchange(nees.seconds, 0.0);
    if (study->film) row.seconds -= std::exchange(study->film->seconds, 0.0);
    row.late = std::exchange(late, kNoNumber);
    ++image;
    if (progress) progress(name, static_cast<double>(image) / static_cast<double>(images));
    const Window& window = estimator.GetWindow();
    if (!row.report.state || !window.prior) return;
    AppendGauge(name, row.t, window, &study->gauge);
    if (spectra == kSpectra || image + 1 < DueImage(spectra, images)) return;
    AppendSpectrum(name, row.t, window, &study->spectrum);
    ++spectra;
  };
  OdometryRun run = RunOdometry(recording, options, std::move(policy), watch);
  if (!pixels.empty()) run.pixels_off = Median(std::move(pixels)) / kMedianOfNormal;
  run.nees_motion = nees.Mean();
  run.nees_windows = static_cast<int>(nees.motions.size());
  study->runs.push_back(std::move(run));
  AppendConsistency(name, nees, &study->consistency);
}

}  // namespace

Recording SimulatedOdometryRecording(uint64_t seed) {
  HandheldOptions path{/*duration=*/20.0, /*standstill_seconds=*/2.0};
  path.seed = seed;
  SimulationOptions options;
  options.imu.seed = seed;
  options.camera.seed = seed + 1;
  options.camera.max_tracks = 40;
  options.camera.outlier_fraction = 0.02;
  return SimulateInRoom(path, 1000, options, seed);
}

OdometryStudy RunOdometryStudy(Recording recording, const StudyProgress& progress, const OdometrySettings& settings,
                               bool batch, bool film) {
  OdometryStudy study;
  study.recording = std::move(recording);
  study.clock_sigma = settings.clock_sigma;
  if (film) study.film.emplace().AppendTruth(study.recording);
  EstimatorOptions options = settings.estimator;
  options.calibration = study.recording.calibration;
  options.report_covariance = options.estimate_extrinsic || options.estimate_time_offset;
  for (auto&& policy : settings.Policies()) Follow(std::move(policy), options, progress, &study);
  if (!batch) return study;
  if (progress) progress("batch", 0.0);
  if (auto run = RunBatch(study.recording, options, study.runs.front())) study.runs.push_back(std::move(*run));
  return study;
}

void WriteOdometryTables(const OdometryStudy& study, const std::filesystem::path& csv) {
  FileBatch files;
  files.Add(csv / "odometry_policies.csv", PolicyTable(study).Text());
  files.Add(csv / "odometry_results.csv", ResultTable(study).Text());
  files.Add(csv / "odometry_segments.csv", SegmentTable(study).Text());
  files.Add(csv / "odometry_path.csv", PathTable(study).Text());
  files.Add(csv / "odometry_lengths.csv", LengthTable(study).Text());
  files.Add(csv / "odometry_consistency.csv", study.consistency.Text());
  files.Add(csv / "odometry_windows.csv", WindowTable(study).Text());
  files.Add(csv / "odometry_spectrum.csv", study.spectrum.Text());
  files.Add(csv / "odometry_gauge.csv", study.gauge.Text());
  files.Add(csv / "odometry_warnings.csv", WarningTable(study).Text());
  files.Add(csv / "odometry_machine.csv", MachineTable(0, {}).Text());
  if (study.film) study.film->AddTo(csv, &files);
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
    for (const ImageResult& row : run.rows) {
      if (!row.report.state) continue;
      std::vector<StampedState>& states = segments[row.report.segment];
      states.push_back(*row.report.state);
      states.back().t = row.t;  // the image's own, by which a file can be joined with others
    }
    for (const auto& [id, states] : segments) {
      const std::string name = run.policy + (id > 0 ? "_" + std::to_string(id) : "");
      const int64_t origin = study.recording.OriginAt(states.empty() ? 0.0 : states.front().t);
      files.Add(out / (name + ".tum"), FormatTum(states, origin));
      files.Add(out / (name + ".csv"), FormatEuroc(states, origin));
      names.insert(name);
    }
  }
  files.Commit();
  RemoveOlderTrajectories(names, out);
}

}  // namespace ch5
