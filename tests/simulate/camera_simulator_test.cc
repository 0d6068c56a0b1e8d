#include "ch5_backend/simulate/sensors/camera_simulator.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "ch5_backend/simulate/sensors/paths.h"
#include "ch5_backend/simulate/sensors/scene_points.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

constexpr double kWallDistance = 5.0;

// Stands at the origin for 10 s and looks along +x.
Trajectory Still() {
  return Trajectory([](const Jet&) { return Coordinates{}; }, 10.0);
}

// Moves along +y at 1 m/s, facing the wall.
Trajectory Sideways() {
  return Trajectory([](const Jet& t) { return Coordinates{{0.0, t, 0.0}, 0.0, 0.0, 0.0}; }, 10.0);
}

std::vector<Vec3> Wall(int count) {
  Random random(7);
  return PointsOnPlanes({{Vec3(kWallDistance, -10, -2), Vec3(0, 30, 0), Vec3(0, 0, 4)}}, count, &random);
}

Calibration AtTheOrigin() {
  Calibration calibration = ForwardCamera();
  calibration.T_B_C.p.setZero();
  return calibration;
}

CameraOptions Exact() {
  CameraOptions options;
  options.pixel_sigma = 0.0;
  return options;
}

// By hand: a point 1 m to the left and half a meter above, 5 m ahead, is at (−0.2, −0.1).
TEST(CameraSimulator, LeftIsLeftAndUpIsUp) {
  const std::vector<Image> frames = SimulateCamera(Still(), {Vec3(5, 1, 0.5)}, AtTheOrigin(), Exact());
  ASSERT_EQ(frames.size(), 201u);
  for (const Image& frame : frames) {
    ASSERT_EQ(frame.tracks.size(), 1u);
    EXPECT_EQ(frame.tracks[0].id, 0);
    EXPECT_LT((frame.tracks[0].x - Vec2(-0.2, -0.1)).norm(), 1e-15);
  }
  EXPECT_EQ(frames[7].t, RoundToNanosecond(0.35));
}

TEST(CameraSimulator, SeesOnlyWhatIsInTheImageAndInRange) {
  CameraOptions options = Exact();
  options.near = 1.0;
  options.far = 10.0;
  const std::vector<Vec3> hidden = {Vec3(-5, 0, 0), Vec3(0.9, 0, 0), Vec3(10.1, 0, 0), Vec3(5, 4.2, 0),
                                    Vec3(5, 0, 2.7)};
  const std::vector<Vec3> seen = {Vec3(1.1, 0, 0), Vec3(9.9, 0, 0), Vec3(5, 4.0, 0), Vec3(5, 0, 2.5)};
  EXPECT_TRUE(SimulateCamera(Still(), hidden, AtTheOrigin(), options).front().tracks.empty());
  EXPECT_EQ(SimulateCamera(Still(), seen, AtTheOrigin(), options).front().tracks.size(), seen.size());
}

// 200 tracks × 201 images × 2 axes: the sampled deviation is good to 1/√(2·80400) ≈ 0.25 % (one sigma).
TEST(CameraSimulator, NoiseHasTheDeviationAskedForInPixels) {
  CameraOptions options;
  options.pixel_sigma = 1.5;
  options.max_tracks = 200;
  const Calibration calibration = AtTheOrigin();
  const std::vector<Vec3> wall = Wall(2000);
  const auto noisy = SimulateCamera(Still(), wall, calibration, options);
  options.pixel_sigma = 0.0;
  const auto exact = SimulateCamera(Still(), wall, calibration, options);
  double sum = 0.0;
  size_t n = 0;
  for (size_t i = 0; i < noisy.size(); ++i) {
    for (size_t k = 0; k < noisy[i].tracks.size(); ++k, n += 2) {
      ASSERT_EQ(noisy[i].tracks[k].id, exact[i].tracks[k].id);
      sum += (calibration.Pixel(noisy[i].tracks[k].x) - calibration.Pixel(exact[i].tracks[k].x)).squaredNorm();
    }
  }
  EXPECT_EQ(n, 2u * 200u * 201u);
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(n)), 1.5, 1.5 * 0.0125);
}

// Past a wall at 1 m/s and 5 m, points move 0.2 of the normalized plane a second to the right.
TEST(CameraSimulator, TracksKeepTheirIdsUntilTheyLeaveTheImage) {
  const Calibration calibration = AtTheOrigin();
  std::map<int, Vec2> last;
  std::set<int> lost;
  for (const Image& frame : SimulateCamera(Sideways(), Wall(500), calibration, Exact())) {
    std::map<int, Vec2> now;
    for (const TrackedPoint& track : frame.tracks) EXPECT_TRUE(now.emplace(track.id, track.x).second);
    for (const auto& [id, x] : now) {
      EXPECT_FALSE(lost.count(id)) << "id " << id << " came back";
      if (const auto before = last.find(id); before != last.end()) {
        EXPECT_LT((x - before->second - Vec2(0.01, 0.0)).norm(), 1e-12);
      }
    }
    for (const auto& [id, x] : last) {
      if (now.count(id)) continue;
      lost.insert(id);
      EXPECT_GT(calibration.Pixel(x + Vec2(0.01, 0.0)).x(), calibration.width - 1e-9);  // over the right edge
    }
    last = now;
  }
  EXPECT_GT(lost.size(), 50u);
}

TEST(CameraSimulator, TracksAreNoLongerAndNoMoreThanAllowed) {
  CameraOptions options = Exact();
  options.max_track_length = 12;
  options.max_tracks = 40;
  std::map<int, int> length;
  for (const Image& frame : SimulateCamera(Sideways(), Wall(500), AtTheOrigin(), options)) {
    EXPECT_LE(frame.tracks.size(), 40u);
    for (const TrackedPoint& track : frame.tracks) ++length[track.id];
  }
  int longest = 0;
  for (const auto& [id, n] : length) longest = std::max(longest, n);
  EXPECT_EQ(longest, 12);
}

// A geometric law: with p = 0.1 a track that nothing else ends lasts 1/p = 10 images on average, ± 9.5/√n;
// leaving out those that the end cuts short favors short ones by less than half an image.
TEST(CameraSimulator, DroppedTracksLastTheirMeanNumberOfImages) {
  CameraOptions options = Exact();
  options.drop_probability = 0.1;
  std::map<int, int> length;
  const auto frames = SimulateCamera(Still(), Wall(500), AtTheOrigin(), options);
  for (const Image& frame : frames) {
    for (const TrackedPoint& track : frame.tracks) ++length[track.id];
  }
  for (const TrackedPoint& track : frames.back().tracks) length.erase(track.id);  // cut short by the end
  double sum = 0.0;
  for (const auto& [id, n] : length) sum += n;
  ASSERT_GT(length.size(), 1000u);
  EXPECT_NEAR(sum / static_cast<double>(length.size()), 10.0, 3 * 9.5 / std::sqrt(length.size()) + 0.5);
}

TEST(CameraSimulator, OutliersAreTheFractionAskedFor) {
  CameraOptions options = Exact();
  options.outlier_fraction = 0.2;
  const std::vector<Vec3> point(1, Vec3(5, 0, 0));
  int outliers = 0, n = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    options.seed = seed;
    for (const Image& frame : SimulateCamera(Still(), point, AtTheOrigin(), options)) {
      outliers += frame.tracks.at(0).x.norm() > 1e-12;
      ++n;
    }
  }
  EXPECT_NEAR(static_cast<double>(outliers) / n, 0.2, 3 * 0.4 / std::sqrt(n));  // binomial, three sigma
}

// At 1 m/s, 5 m from the wall, a clock that is 50 ms late shifts the images by 0.01; frames out of time are left out.
TEST(CameraSimulator, ImagesAreTakenTheTimeOffsetAfterTheirStamp) {
  CameraOptions options = Exact();
  const std::vector<Vec3> point(1, Vec3(5, 2, 0));
  const auto on_time = SimulateCamera(Sideways(), point, AtTheOrigin(), options);
  options.time_offset = 0.05;
  const auto late = SimulateCamera(Sideways(), point, AtTheOrigin(), options);
  ASSERT_EQ(late.size(), on_time.size() - 1);
  for (size_t n = 0; n < 40; ++n) {
    EXPECT_EQ(late[n].t, on_time[n].t);
    EXPECT_LT((late[n].tracks.at(0).x - on_time[n].tracks.at(0).x - Vec2(0.01, 0.0)).norm(), 1e-12);
  }
  options.time_offset = -0.05;
  EXPECT_EQ(SimulateCamera(Sideways(), point, AtTheOrigin(), options).front().t, on_time[1].t);
}

TEST(CameraSimulator, RefusesOptionsThatMakeNoSense) {
  const auto refuses = [](auto change) {
    CameraOptions options;
    Calibration calibration;
    change(&options, &calibration);
    EXPECT_THROW(SimulateCamera(Still(), {}, calibration, options), std::invalid_argument);
  };
  refuses([](CameraOptions* o, Calibration*) { o->pixel_sigma = -1.0; });
  refuses([](CameraOptions* o, Calibration*) { o->near = 0.0; });
  refuses([](CameraOptions* o, Calibration*) { o->outlier_fraction = 1.1; });
  refuses([](CameraOptions* o, Calibration*) { o->drop_probability = std::nan(""); });
  refuses([](CameraOptions* o, Calibration*) { o->max_track_length = 0; });
  refuses([](CameraOptions* o, Calibration*) { o->time_offset = INFINITY; });
  refuses([](CameraOptions*, Calibration* c) { c->camera_rate = 0.0; });
}

TEST(ScenePoints, LieOnTheirPlanesInProportionToTheirArea) {
  Random random(3);
  const std::vector<PlanePatch> patches = {{Vec3(0, 0, 1), Vec3(3, 0, 0), Vec3(0, 1, 0)},
                                           {Vec3(0, 0, 2), Vec3(1, 0, 0), Vec3(0, 1, 0)}};
  int first = 0;
  for (const Vec3& p : PointsOnPlanes(patches, 4000, &random)) {
    EXPECT_TRUE(p.z() == 1.0 || p.z() == 2.0);
    first += p.z() == 1.0;
    EXPECT_TRUE(p.x() >= 0.0 && p.x() < (p.z() == 1.0 ? 3.0 : 1.0) && p.y() >= 0.0 && p.y() < 1.0);
  }
  EXPECT_NEAR(first, 3000, 3 * 27.4);  // binomial, three sigma
}

// The truth of the recording explains its images: every observation is of one point, within the noise.
TEST(Simulation, RecordingIsConsistentWithItsTruth) {
  const Trajectory trajectory = GaugePaperPath(GaugePath::kArc);
  SimulationOptions options;
  options.camera.pixel_sigma = 0.0;
  options.camera.time_offset = 0.01;
  const std::vector<Vec3> point(1, Vec3(0, 4, 0));
  const Recording recording = SimulateRecording(trajectory, point, options);
  ASSERT_GT(recording.images.size(), 40u);
  EXPECT_EQ(recording.truth.size(), recording.imu.size());
  const Transform& T_B_C = recording.calibration.T_B_C;
  for (const Image& frame : recording.images) {
    const std::optional<StampedState> state = StateAt(recording.truth, frame.t + 0.01);
    ASSERT_TRUE(state);
    const Vec3 p_B = state->T_W_B.q.conjugate() * (point[0] - state->T_W_B.p);
    const Vec3 p_C = T_B_C.q.conjugate() * (p_B - T_B_C.p);
    for (const TrackedPoint& track : frame.tracks) EXPECT_LT((p_C.hnormalized() - track.x).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace ch5
