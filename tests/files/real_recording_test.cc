/// A recorded flight, and a simulated one for who lacks it: its files are read, and its measurements agree with its ground truth.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <set>

#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/simulate/sensors/scene_points.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/types/inertial/preintegration.h"
#include "tests/data_folder.h"
#include "tests/temporary_folder.h"

namespace ch5 {
namespace {

namespace fs = std::filesystem;

double LengthOf(const std::vector<StampedState>& path) {
  double length = 0.0;
  for (size_t k = 1; k < path.size(); ++k) length += (path[k].T_W_B.p - path[k - 1].T_W_B.p).norm();
  return length;
}

// What the data's own description says of it.
TEST(RealRecording, IsReadWhole) {
  const fs::path folder = DataFolder() / "euroc_v1_01_easy";
  CH5_NEEDS(folder);
  const Recording recording = ReadRecording(folder);
  EXPECT_EQ(recording.imu.size(), 6001u);
  EXPECT_EQ(recording.images.size(), 601u);
  EXPECT_EQ(recording.origin_ns, 1403715273262143232);
  EXPECT_NEAR(recording.imu.back().t, 30.0, 1e-3);
  std::set<int> ids;
  for (const Image& frame : recording.images) {
    for (const TrackedPoint& track : frame.tracks) ids.insert(track.id);
  }
  EXPECT_EQ(ids.size(), 307u);
  EXPECT_EQ(recording.calibration.fx, 458.654);
  EXPECT_EQ(recording.calibration.width, 752);
  EXPECT_EQ(recording.calibration.noise.gyroscope, 1.6968e-4);
  EXPECT_NEAR(recording.imu.front().acceleration.norm(), 9.81, 0.1);  // it stands still
  EXPECT_NEAR(LengthOf(recording.truth), 8.2, 0.3);
}

// Eight seconds of a hand-held camera, without noise: its motion is a formula.
const Trajectory& Formula() {
  static const Trajectory handheld = Handheld({8.0});
  return handheld;
}

Recording Simulated() {
  SimulationOptions options;
  options.imu.noise_scale = 0.0;
  options.camera.pixel_sigma = 0.0;
  Random random(1);
  return SimulateRecording(Formula(), PointsOnPlanes(RoomWalls({-5, -5, -2.5}, {5, 5, 2.5}), 1000, &random), options);
}

struct Flight {
  const char* name;
  double p, v, angle;  // how far the IMU may lead from the truth in half a second [m, m/s, rad]
  double pixels;       // the median error of what is tracked
};
void PrintTo(const Flight& flight, std::ostream* out) { *out << flight.name; }

class Flights : public testing::TestWithParam<Flight> {
 protected:
  void SetUp() override {
    const bool is_real = std::string(GetParam().name) == "recorded";
    const test::TemporaryFolder made;
    const fs::path folder = is_real ? DataFolder() / "euroc_v1_01_easy" : made.Path();
    if (!is_real) WriteRecording(Simulated(), folder);
    CH5_NEEDS(folder);
    recording_ = ReadRecording(folder);
  }
  Recording recording_;
};

// Measured of the recorded one: 1.2 cm, 0.05 m/s, 0.16°; 1.3 px, 0.8 px if the pixels' errors are minimized rather than the
// rays' distances. A wrong frame, sign or unit is off by meters or radians.
INSTANTIATE_TEST_SUITE_P(, Flights,
                         testing::Values(Flight{"recorded", 0.03, 0.1, 0.01, 1.5},
                                         Flight{"simulated", 1e-4, 1e-4, 1e-4, 1e-3}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(SimulatedFlight, IsReadWhole) {
  const test::TemporaryFolder folder;
  WriteRecording(Simulated(), folder.Path());
  const Recording recording = ReadRecording(folder.Path());
  EXPECT_EQ(recording.imu.size(), 1601u);
  EXPECT_EQ(recording.images.size(), 161u);
  EXPECT_EQ(recording.calibration.fx, ForwardCamera().fx);
  EXPECT_NEAR(LengthOf(recording.truth) / PathLength(Formula()), 1.0, 1e-4);
}

// The frames' conventions, all at once: over half a second, the recorded IMU carries the true state on to the next.
TEST_P(Flights, ImuAgreesWithTheGroundTruth) {
  const Recording& recording = recording_;
  const Vec3 g = recording.calibration.GravityInWorld();
  double worst_p = 0.0, worst_angle = 0.0, worst_v = 0.0;
  for (size_t k = 100; k + 10 < recording.truth.size(); k += 10) {
    const StampedState &i = recording.truth[k], &j = recording.truth[k + 10];
    const std::vector<ImuSample> samples = SamplesBetween(recording.imu, i.t, j.t);
    ASSERT_FALSE(samples.empty());
    Preintegration imu(samples.front(), i.b_a, i.b_g, recording.calibration.noise);
    for (size_t m = 1; m < samples.size(); ++m) imu.Add(samples[m]);
    const double dt = imu.SumDt();
    const Vec3 p = i.T_W_B.p + i.v_W * dt + 0.5 * dt * dt * g + i.T_W_B.q * imu.Alpha();
    const Vec3 v = i.v_W + dt * g + i.T_W_B.q * imu.Beta();
    worst_p = std::max(worst_p, (p - j.T_W_B.p).norm());
    worst_v = std::max(worst_v, (v - j.v_W).norm());
    worst_angle = std::max(worst_angle, LogSO3((i.T_W_B.q * imu.Gamma()).conjugate() * j.T_W_B.q).norm());
  }
  EXPECT_LT(worst_p, GetParam().p);
  EXPECT_LT(worst_v, GetParam().v);
  EXPECT_LT(worst_angle, GetParam().angle);
}

struct Ray {
  Qd q_W_C;
  Vec3 p_W_C;
  Vec2 x;
};

// Σ (I − ffᵀ)(X − p) = 0.
Vec3 PointNearestTo(const std::vector<Ray>& rays) {
  Mat33 A = Mat33::Zero();
  Vec3 b = Vec3::Zero();
  for (const Ray& ray : rays) {
    const Vec3 f = (ray.q_W_C * ray.x.homogeneous()).normalized();
    const Mat33 across = Mat33::Identity() - f * f.transpose();
    A += across;
    b += across * ray.p_W_C;
  }
  return A.inverse() * b;
}

// And the camera's: each track meets in one point when its rays are drawn from the true poses.
TEST_P(Flights, TracksMeetInPointsAtTheTruePoses) {
  const Recording& recording = recording_;
  const Transform& T_B_C = recording.calibration.T_B_C;
  std::map<int, std::vector<Ray>> tracks;
  for (const Image& frame : recording.images) {
    const std::optional<StampedState> state = StateAt(recording.truth, frame.t);
    if (!state) continue;
    const auto& [q, p] = state->T_W_B;
    for (const TrackedPoint& track : frame.tracks) tracks[track.id].push_back({q * T_B_C.q, q * T_B_C.p + p, track.x});
  }
  std::vector<double> errors;  // [px]
  for (const auto& [id, rays] : tracks) {
    const Vec3 X = PointNearestTo(rays);
    for (const Ray& ray : rays) {
      const Vec3 p_C = ray.q_W_C.conjugate() * (X - ray.p_W_C);
      errors.push_back(recording.calibration.fx * (p_C.hnormalized() - ray.x).norm());
    }
  }
  ASSERT_GT(errors.size(), 10000u);
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], GetParam().pixels);
}

}  // namespace
}  // namespace ch5
