// Thirty keyframes of a real recording as the gauge paper's problem.  Zhang (2018), Table III
#include <Eigen/Cholesky>
#include <map>
#include <stdexcept>

#include "ch5_backend/experiments/studies/gauge/gauge_solve.h"
#include "ch5_backend/experiments/studies/gauge/gauge_studies.h"
#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/window/prediction.h"

namespace ch5 {
namespace {

constexpr int kKeyframes = 30, kMinViews = 4;
constexpr double kPixelSigma = 1.0, kOutlierPixels = 3.0;
constexpr double kNearest = 1.0;  // depth [m]: a start 7.5 cm beside a nearer point may lie behind a camera

// Where trial k takes its keyframes.
struct Segment {
  const char* recording;
  double first, shift;  ///< time of the first keyframe of trial 0, and from trial to trial [s]
  int stride;           ///< images from keyframe to keyframe, about a quarter of a second
};
constexpr Segment kSegments[] = {{"euroc_v1_01_easy", 7.0, 0.3, 5}, {"tango_walk", 7.0, 2.0, 2}};

struct Ray {
  int keyframe;
  Vec2 u;
  Vec3 center, direction;  // of the camera, and unit, in W
};

// The point nearest to all rays:  Σ (I − f fᵀ)(X − c) = 0.
Vec3 NearestPoint(const std::vector<Ray>& rays) {
  Mat33 A = Mat33::Zero();
  Vec3 b = Vec3::Zero();
  for (const Ray& ray : rays) {
    const Mat33 across = Mat33::Identity() - ray.direction * ray.direction.transpose();
    A += across;
    b += across * ray.center;
  }
  return A.ldlt().solve(b);
}

bool IsInlier(const Calibration& calibration, const Transform& T_W_B, const Ray& ray, const Vec3& X) {
  const Vec3 p_C = (T_W_B.q * calibration.T_B_C.q).conjugate() * (X - ray.center);
  return p_C.z() > kNearest && calibration.fx * (p_C.hnormalized() - ray.u).norm() < kOutlierPixels;
}

// What agrees with the true poses, of tracks that are seen often enough.
void AddTracks(const std::map<int, std::vector<Ray>>& tracks, VisualInertialScene* scene) {
  for (const auto& [id, rays] : tracks) {
    const Vec3 X = NearestPoint(rays);
    std::vector<Ray> inliers;
    for (const Ray& ray : rays) {
      if (IsInlier(scene->calibration, scene->truth[ray.keyframe].T_W_B, ray, X)) inliers.push_back(ray);
    }
    if (!X.allFinite() || inliers.size() < kMinViews) continue;
    for (const Ray& ray : inliers) {
      scene->observations.push_back({ray.keyframe, static_cast<int>(scene->points.size()), ray.u});
    }
    scene->points.push_back(X);
  }
}

VisualInertialScene SceneOf(const Recording& recording, double first, int stride) {
  VisualInertialScene scene;
  scene.calibration = recording.calibration;
  scene.pixel_sigma = kPixelSigma;
  const Transform& T_B_C = recording.calibration.T_B_C;
  std::map<int, std::vector<Ray>> tracks;
  int image = 0;
  for (const Image& frame : recording.images) {
    if (frame.t < first || image++ % stride != 0) continue;
    auto state = StateAt(recording.truth, frame.t);
    if (!state) continue;
    const int keyframe = static_cast<int>(scene.truth.size());
    state->t = frame.t;
    scene.truth.push_back(*state);
    for (const TrackedPoint& track : frame.tracks) {
      const Vec3 f = state->T_W_B.q * (T_B_C.q * track.x.homogeneous().normalized());
      tracks[track.id].push_back({keyframe, track.x, state->T_W_B.q * T_B_C.p + state->T_W_B.p, f});
    }
    if (static_cast<int>(scene.truth.size()) == kKeyframes) break;
  }
  if (static_cast<int>(scene.truth.size()) < kKeyframes) throw std::runtime_error("the recording has too few images");
  AddTracks(tracks, &scene);
  for (size_t i = 0; i + 1 < scene.truth.size(); ++i) {
    scene.imu.push_back(IntegrateFrom(scene.truth[i], recording.imu, scene.truth[i + 1].t, scene.calibration.noise));
  }
  return scene;
}

}  // namespace

CsvTable GaugeRecordingsTable(int trial, const std::filesystem::path& data) {
  CsvTable table(
      "recording,method,trial,points,iterations,milliseconds,position_m,rotation_deg,velocity_m_s,reprojection_px");
  const std::pair<const char*, GaugeMethod> methods[] = {{"fixation", {GaugeHandling::kFixation}},
                                                         {"free", {GaugeHandling::kFree}},
                                                         {"prior", {GaugeHandling::kPrior, 1e5}}};
  for (const Segment& segment : kSegments) {
    const Recording recording = ReadRecording(data / segment.recording);
    VisualInertialScene scene = SceneOf(recording, segment.first + segment.shift * trial, segment.stride);
    PerturbStart({}, static_cast<uint64_t>(trial) + 1, &scene);
    for (const auto& [name, method] : methods) {
      const GaugeRun run = SolveGauge(scene, method);
      table.Row(segment.recording, name, trial, scene.points.size(), run.summary.iterations, run.milliseconds,
                run.error.position_rmse, run.error.rotation_rmse * 180.0 / M_PI, run.error.velocity_rmse,
                run.reprojection_px.back());
    }
  }
  return table;
}

}  // namespace ch5
