// What becomes of what leaves the window.  Huang, Mourikis, Roumeliotis, IJRR 2010
#include <cmath>

#include "ch5_backend/evaluate/nees.h"
#include "ch5_backend/experiments/studies/consistency_flight.h"
#include "ch5_backend/experiments/studies/motion_nees.h"
#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/marginalize/marginalize.h"

namespace ch5 {
namespace {

using Edges = std::vector<std::shared_ptr<Edge>>;
using Vertices = std::vector<std::shared_ptr<Vertex>>;

// What is constant has no column: what remains is conditional on it, H_kk instead of H_kk − H_kd H_dd⁺ H_dk.
std::shared_ptr<EdgePrior> Fix(const Edges& edges, const Vertices& leaving, bool speeds_too) {
  for (const auto& vertex : leaving) {
    const bool is_pose = dynamic_cast<const VertexPose*>(vertex.get()) != nullptr;
    if (is_pose || (speeds_too && vertex->GetRole() != Role::kLandmark)) vertex->SetFixed();
  }
  return std::make_shared<EdgePrior>(Marginalize(edges, leaving));
}

struct Way {
  const char* name;
  Marginalizer marginalizer;
  ObservabilityConstraints constraints = ObservabilityConstraints::kNone;
};
const Way kWays[] = {
    {"dropped", [](const Edges&, const Vertices&) { return nullptr; }},
    {"fixed", [](const Edges& edges, const Vertices& leaving) { return Fix(edges, leaving, true); }},
    {"poses fixed", [](const Edges& edges, const Vertices& leaving) { return Fix(edges, leaving, false); }},
    {"marginalized", nullptr},
    {"first estimates", nullptr, ObservabilityConstraints::kAllEdges}};

CsvTable EmptyTable() {
  return CsvTable("recording,policy,way,trial,images,restarts,ate_m,nees_world,nees_motion,milliseconds");
}

struct FlightResult {
  std::string policy;
  MotionNees found = {};
  size_t images = 0;
  int restarts = 0;
  double ate = kNoNumber, nees_world = kNoNumber, nees_motion = kNoNumber, milliseconds = kNoNumber;
};

// @param start  of a simulated flight, in whose W the pose is compared too
FlightResult Fly(const Recording& recording, const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy,
                 const DrawnStart* start, const Mat66& truth = Mat66::Zero()) {
  FlightResult flight{policy->Name()};
  MotionNees& found = flight.found;
  found.truth = truth;
  policy = ComparedBeforeSlides(std::move(policy), recording.truth, start ? 1 : 10, &found);
  const auto watch = [](Window* window, const std::function<void()>& slide) {
    slide();
    window->prior_fixes_gauge &= window->prior != nullptr;  // dropped: position and yaw are free again
  };
  Estimator estimator(options, std::make_unique<WrappedPolicy>(std::move(policy), watch));
  if (start) estimator.StartFrom(start->state, start->J);
  std::vector<StampedState> states;
  double nees = 0.0, claims = 0.0, seconds = 0.0;
  FeedRecording(recording, &estimator, [&](const Estimator&, const ImageResult& row) {
    seconds += row.seconds;
    if (!row.report.state) return;
    states.push_back(*row.report.state);
    if (!row.report.covariance) return;
    const StampedState truth = *StateAt(recording.truth, row.t);
    nees += ComparePose(row.report.state->T_W_B, row.report.covariance->Pose(), truth.T_W_B).nees;
    ++claims;
  });
  flight.images = states.size();
  flight.restarts = estimator.Restarts();
  if (const auto error = CompareTrajectories(states, recording.truth)) flight.ate = error->position_rmse;
  if (start) flight.nees_world = nees / claims;  // NaN if there is none
  flight.nees_motion = found.Mean();
  flight.milliseconds = 1e3 * (seconds - found.seconds) / static_cast<double>(recording.images.size());
  return flight;
}

void Append(const std::string& name, const Recording& recording, EstimatorOptions options,
            std::unique_ptr<WindowPolicy> policy, const Way& way, const DrawnStart* start, int trial, CsvTable* table) {
  options.observability_constraints = way.constraints;
  options.marginalizer = way.marginalizer;
  const FlightResult flight = Fly(recording, options, std::move(policy), start);
  table->Row(name, flight.policy, way.name, trial, flight.images, flight.restarts, flight.ate, flight.nees_world,
             flight.nees_motion, flight.milliseconds);
}

}  // namespace

CsvTable AblationTable(int trial, const std::filesystem::path&) {
  CsvTable table = EmptyTable();
  const Recording recording = ConsistencyFlight({}, trial);
  const DrawnStart start = DrawStart(recording.truth.front(), trial);
  for (const char* policy : {"vins", "okvis"}) {
    for (const Way& way : kWays) {
      const ConsistencyCase c{policy, "once", "noisy", "none"};
      const EstimatorOptions options = ConsistencyEstimator(c, recording.calibration);
      Append("simulated", recording, options, ConsistencyPolicy(c), way, &start, trial, &table);
    }
  }
  return table;
}

CsvTable CertaintyTable(int trial, const std::filesystem::path&) {
  CsvTable table("trial,observations,hosts,weights,nees");
  const Recording recording = ConsistencyFlight({}, trial);
  const DrawnStart start = DrawStart(recording.truth.front(), trial);
  for (const char* hosts : {"exact", "noisy", "published"}) {
    for (const char* observations : {"once", "twice"}) {
      const ConsistencyCase c{"vins", observations, hosts, "none"};
      const EstimatorOptions options = ConsistencyEstimator(c, recording.calibration);
      const bool published = c.hosts == "published";
      table.Row(trial, observations, published ? "exact" : hosts, published ? "published" : "as simulated",
                Fly(recording, options, ConsistencyPolicy(c), &start).nees_world);
    }
  }
  return table;
}

CsvTable AblationRecordingTable(int trial, const std::filesystem::path& data) {
  CsvTable table = EmptyTable();
  const Recording recording = ReadRecording(data / "euroc_v1_01_easy");
  for (const Way& way : kWays) {
    for (auto&& policy : AllPolicies()) {
      Append("euroc_v1_01_easy", recording, EstimatorOptions{recording.calibration}, std::move(policy), way, nullptr,
             trial, &table);
    }
  }
  return table;
}

namespace {

void ScaleImu(double factor, EstimatorOptions* options) {
  ImuNoise& noise = options->calibration.noise;
  for (double* sigma : {&noise.accelerometer, &noise.gyroscope, &noise.accelerometer_walk, &noise.gyroscope_walk}) {
    *sigma *= factor;
  }
}

// Settings of the estimator; all recordings have the first three, of first estimates, V1_01 has all.
constexpr std::ptrdiff_t kModes = 3;
struct Setting {
  const char* name;
  void (*set)(EstimatorOptions*);
  double truth_position = 0.0, truth_rotation = 0.0;  // the truth's own σ on each axis [m, rad]
};
using Constraints = ObservabilityConstraints;
const Setting kSettings[] = {
    {"none", [](EstimatorOptions*) {}},
    {"prior", [](EstimatorOptions* o) { o->observability_constraints = Constraints::kMarginalizedEdges; }},
    {"full", [](EstimatorOptions* o) { o->observability_constraints = Constraints::kAllEdges; }},
    {"outliers beyond 1.5 px", [](EstimatorOptions* o) { o->max_outlier_pixels = 1.5; }},
    {"T_B_C and clock estimated", [](EstimatorOptions* o) { o->estimate_extrinsic = o->estimate_time_offset = true; }},
    {"pixels x 3", [](EstimatorOptions* o) { o->weights.pixel_sigma *= 3.0; }},
    {"IMU x 3", [](EstimatorOptions* o) { ScaleImu(3.0, o); }},
    {"both x 3", [](EstimatorOptions* o) { o->weights.pixel_sigma *= 3.0, ScaleImu(3.0, o); }},
    {"both x 5", [](EstimatorOptions* o) { o->weights.pixel_sigma *= 5.0, ScaleImu(5.0, o); }},
    {"truth errs too", [](EstimatorOptions*) {}, 3e-3, 0.1 * M_PI / 180.0}};

}  // namespace

CsvTable ConsistencyRecordingTable(int trial, const std::filesystem::path& data) {
  CsvTable table(
      "recording,policy,setting,trial,images,restarts,ate_m,nees_motion,position_m,position_claimed_m,rotation_deg,"
      "rotation_claimed_deg,yaw_leak,milliseconds");
  const char* names[] = {"euroc_v1_01_easy", "tango_walk"};
  const bool simulated = trial > 1;
  const std::string name = simulated ? "simulated" : names[trial];
  const Recording recording =
      simulated ? SimulatedOdometryRecording(static_cast<uint64_t>(trial) - 1) : ReadRecording(data / name);
  const std::ptrdiff_t cases = trial == 0 ? std::size(kSettings) : kModes;
  for (const Setting* setting = kSettings; setting != kSettings + cases; ++setting) {
    for (auto&& policy : AllPolicies()) {
      EstimatorOptions options{recording.calibration};
      setting->set(&options);
      Vec6 truth = Vec6::Constant(std::pow(setting->truth_position, 2));
      truth.tail<3>().setConstant(std::pow(setting->truth_rotation, 2));
      const FlightResult flight = Fly(recording, options, std::move(policy), nullptr, truth.asDiagonal());
      const auto& found = flight.found;
      const double degrees = 180.0 / M_PI;
      table.Row(name, flight.policy, setting->name, trial, flight.images, flight.restarts, flight.ate,
                flight.nees_motion, found.Errors()[0], found.Claimed()[0], degrees * found.Errors()[1],
                degrees * found.Claimed()[1], found.yaw_leak / found.priors, flight.milliseconds);
    }
  }
  return table;
}

namespace {

// @param whole  all kinds of flight, modes and policies; else those of which ./course refute asks
CsvTable FirstEstimates(int trial, bool whole) {
  CsvTable table("recording,policy,setting,trial,images,restarts,ate_m,nees_motion");
  const auto fly = [&](const char* name, const Recording& recording, const DrawnStart* start) {
    for (const Setting* setting = kSettings; setting != kSettings + kModes; ++setting) {
      if (!whole && setting->name == std::string("prior")) continue;
      for (auto&& policy : AllPolicies()) {
        if (!whole && policy->Name() != "vins") continue;
        EstimatorOptions options{recording.calibration};
        setting->set(&options);
        const FlightResult flight = Fly(recording, options, std::move(policy), start);
        table.Row(name, flight.policy, setting->name, trial, flight.images, flight.restarts, flight.ate,
                  flight.nees_motion);
      }
    }
  };
  const auto circle = [&](const char* name, const ConsistencyOptions& options) {
    const Recording recording = ConsistencyFlight(options, trial);
    const DrawnStart start = DrawStart(recording.truth.front(), trial);
    fly(name, recording, &start);
  };
  circle("ahead", {});
  if (whole) {
    ConsistencyOptions outward, many;
    outward.heading = 0.0;
    many.max_tracks = 100;
    many.camera_rate = 10.0;
    circle("ahead with 100 tracks", many);
    circle("outward", outward);
  }
  fly("hand-held", SimulatedOdometryRecording(1 + static_cast<uint64_t>(trial)), nullptr);
  return table;
}

}  // namespace

CsvTable FirstEstimatesTable(int trial, const std::filesystem::path&) { return FirstEstimates(trial, true); }
CsvTable RefutedEstimatesTable(int trial, const std::filesystem::path&) { return FirstEstimates(trial, false); }

}  // namespace ch5
