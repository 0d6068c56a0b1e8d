#include "ch5_backend/window/start/dynamic_initialization.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "ch5_backend/files/recording_file.h"
#include "ch5_backend/math/median.h"
#include "ch5_backend/simulate/sensors/paths.h"
#include "ch5_backend/simulate/sensors/scene_points.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/window/start/closed_form.h"
#include "tests/data_folder.h"

namespace ch5 {
namespace {

// Every `stride`-th image from the one at index `first` on, with the IMU in between integrated at no bias.
std::vector<InitializationImage> Cut(const Recording& recording, size_t first, size_t count, size_t stride) {
  std::vector<InitializationImage> frames;
  for (size_t k = first; k < recording.images.size() && frames.size() < count; k += stride) {
    const Image& image = recording.images[k];
    InitializationImage frame{image.t, image.tracks, nullptr, image.tracks1};
    if (!frames.empty()) {
      const auto samples = SamplesBetween(recording.imu, frames.back().t, frame.t);
      frame.imu = std::make_shared<Preintegration>(samples, Vec3::Zero(), Vec3::Zero(), recording.calibration.noise);
    }
    frames.push_back(frame);
  }
  return frames;
}

DynamicInitializationOptions OptionsFor(const Recording& recording) {
  DynamicInitializationOptions options;
  options.T_B_C = recording.calibration.T_B_C;
  options.focal_length = recording.calibration.fx;
  options.gravity = recording.calibration.gravity;
  return options;
}

struct Errors {
  double gravity = 0.0;   // angle [rad]
  double scale = 0.0;     // relative
  double b_g = 0.0;       // [rad/s]
  double velocity = 0.0;  // of the last state, in its body [m/s]
};

Errors Compare(const DynamicInitialization& start, const Recording& recording) {
  Errors errors;
  double length = 0.0, true_length = 0.0;
  const StampedState first = *StateAt(recording.truth, start.states.front().t);
  for (const StampedState& state : start.states) {
    const StampedState truth = *StateAt(recording.truth, state.t);
    const Vec3 up = state.T_W_B.q.conjugate() * Vec3::UnitZ(), true_up = truth.T_W_B.q.conjugate() * Vec3::UnitZ();
    errors.gravity = std::max(errors.gravity, std::acos(std::min(1.0, up.dot(true_up))));
    errors.b_g = std::max(errors.b_g, (state.b_g - truth.b_g).norm());
    length += state.T_W_B.p.norm();
    true_length += (truth.T_W_B.p - first.T_W_B.p).norm();
    errors.velocity = (state.T_W_B.q.conjugate() * state.v_W - truth.T_W_B.q.conjugate() * truth.v_W).norm();
  }
  errors.scale = std::abs(length / true_length - 1.0);
  return errors;
}

Recording Fly(uint64_t seed, const CameraOptions& camera, const Calibration& calibration = ForwardCamera()) {
  HandheldOptions handheld;
  handheld.seed = seed;
  handheld.duration = 12.0;
  Random random(seed);
  const SimulationOptions options{calibration, {}, camera};
  return SimulateRecording(Handheld(handheld), PointsOnPlanes(RoomWalls({-6, -6, -3}, {6, 6, 3}), 600, &random),
                           options);
}

// Eleven images in two seconds, as a window of VINS holds them.
constexpr size_t kImages = 11, kStride = 4;

void ExpectGoodStarts(uint64_t seed, double outlier_fraction, size_t step, double most_degrees) {
  CameraOptions camera;
  camera.pixel_sigma = 0.5;
  camera.outlier_fraction = outlier_fraction;
  const Recording recording = Fly(seed, camera);
  for (size_t first = 10; first < 190; first += step) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", image " + std::to_string(first));
    const DynamicInitialization start =
        InitializeDynamically(Cut(recording, first, kImages, kStride), OptionsFor(recording));
    ASSERT_EQ(start.failure, InitializationFailure::kNone) << start.message;
    const Errors errors = Compare(start, recording);
    EXPECT_LT(errors.gravity, most_degrees / 57.3);
    EXPECT_LT(errors.scale, 0.05);
    EXPECT_LT(errors.b_g, 5e-3);
    EXPECT_LT(errors.velocity, 0.05);
  }
}

TEST(DynamicInitialization, FindsGravityScaleAndBias) {
  for (const uint64_t seed : {1u, 2u, 3u}) ExpectGoodStarts(seed, 0.0, 20, 1.0);
}

TEST(DynamicInitialization, BearsOutliers) { ExpectGoodStarts(4, 0.1, 40, 2.0); }

// The flying part of the real recording, cut at every second: none starts wrong, most start.
TEST(DynamicInitialization, StartsInTheMiddleOfARealFlight) {
  const auto folder = DataFolder() / "euroc_v1_01_easy";
  CH5_NEEDS(folder);
  const Recording recording = ReadRecording(folder);
  int cuts = 0, started = 0;
  std::vector<double> scales;
  for (size_t first = 200; first + kImages * kStride < recording.images.size(); first += 20) {
    const DynamicInitialization start =
        InitializeDynamically(Cut(recording, first, kImages, kStride), OptionsFor(recording));
    ++cuts;
    if (start.failure != InitializationFailure::kNone) continue;
    ++started;
    const Errors errors = Compare(start, recording);
    EXPECT_LT(errors.gravity, 2.0 / 57.3) << "image " << first;
    EXPECT_LT(errors.scale, 0.1) << "image " << first;
    EXPECT_LT(errors.b_g, 0.01) << "image " << first;
    scales.push_back(errors.scale);
  }
  EXPECT_GE(started, 0.75 * cuts);
  EXPECT_LT(Median(scales), 0.05);
  RecordProperty("started", std::to_string(started) + " of " + std::to_string(cuts));
}

// While the acceleration hardly changes, a motion several times as large explains almost the same.
TEST(DynamicInitialization, ChoosesTheBetterOfTwoSolutions) {
  HandheldOptions path;
  path.duration = 20.0;
  int starts = 0;
  for (path.seed = 1; path.seed <= 2; ++path.seed) {
    SimulationOptions options;
    options.imu.seed = path.seed + 1;
    options.camera.seed = path.seed + 2;
    options.camera.pixel_sigma = 0.5;
    options.camera.max_tracks = 100;
    const Recording recording = SimulateInRoom(path, 1500, options, path.seed);
    for (size_t first = 0; first + 20 < recording.images.size(); first += 7) {
      const DynamicInitialization start = InitializeDynamically(Cut(recording, first, 9, 2), OptionsFor(recording));
      EXPECT_NE(start.failure, InitializationFailure::kInconsistent) << "seed " << path.seed << ", image " << first;
      if (start.failure != InitializationFailure::kNone) continue;
      ++starts;
      EXPECT_LT(Compare(start, recording).scale, 0.3) << "seed " << path.seed << ", image " << first;
    }
  }
  EXPECT_GT(starts, 50);
}

// A pixel of camera 1 is four times as wide as one of camera 0: weighed alike, half of what it sees would not fit.
TEST(DynamicInitialization, WeighsEachCameraByItsOwnFocalLength) {
  Calibration calibration = ForwardStereo();
  calibration.camera1->fx = calibration.camera1->fy = 0.25 * calibration.fx;
  const Recording recording = Fly(1, {}, calibration);
  DynamicInitializationOptions options = OptionsFor(recording);
  options.camera1 = calibration.camera1;
  for (size_t first = 10; first < 190; first += 60) {
    const DynamicInitialization start = InitializeDynamically(Cut(recording, first, kImages, kStride), options);
    ASSERT_EQ(start.failure, InitializationFailure::kNone) << start.message;
    EXPECT_GT(start.inliers, 0.95) << "image " << first;
  }
}

// Points that are seen far better than σ says, in half a second: what is taken off for their noise must be their own, or the
// scale grows with it.
TEST(DynamicInitialization, NoiseThatIsNotThereDoesNotStretchTheScale) {
  Random random(5);
  SimulationOptions options;
  options.camera.pixel_sigma = 0.2;
  const auto quick = [](const Jet& t) {
    return Coordinates{{1.2 * Sin(1.3 * t), 0.8 * Cos(1.7 * t), 0.3 * Sin(2.1 * t)}, 0.6 * Sin(0.9 * t), 0.0, 0.0};
  };
  const Recording recording = SimulateRecording(
      Trajectory(quick, 12.0), PointsOnPlanes(RoomWalls({-6, -6, -3}, {6, 6, 3}), 600, &random), options);
  int started = 0;
  for (size_t first = 10; first < 220; first += 5) {
    const DynamicInitialization start = InitializeDynamically(Cut(recording, first, 12, 1), OptionsFor(recording));
    if (start.failure != InitializationFailure::kNone) continue;
    ++started;
    EXPECT_LT(Compare(start, recording).scale, 0.1) << "image " << first;
  }
  EXPECT_GE(started, 8);
}

// ---- what cannot start says why --------------------------------------------------------------------------------

DynamicInitialization StartOn(const Trajectory::Formula& formula) {
  Random random(5);
  const Recording recording =
      SimulateRecording(Trajectory(formula, 3.0), PointsOnPlanes(RoomWalls({-6, -6, -3}, {6, 6, 3}), 600, &random));
  return InitializeDynamically(Cut(recording, 5, kImages, kStride), OptionsFor(recording));
}

TEST(DynamicInitialization, StandingHasNoParallax) {
  const DynamicInitialization start = StartOn([](const Jet&) { return Coordinates{}; });
  EXPECT_EQ(start.failure, InitializationFailure::kTooLittleParallax) << start.message;
  EXPECT_TRUE(start.states.empty());
  EXPECT_NE(start.message.find("px"), std::string::npos);
}

TEST(DynamicInitialization, TurningHasNoParallax) {
  const DynamicInitialization start = StartOn([](const Jet& t) {
    return Coordinates{{0.0, 0.0, 0.0}, 0.4 * t, 0.0, 0.0};
  });
  EXPECT_EQ(start.failure, InitializationFailure::kTooLittleParallax) << start.message;
}

TEST(DynamicInitialization, ConstantVelocityHasNoScale) {
  const DynamicInitialization start = StartOn([](const Jet& t) {
    return Coordinates{{0.0, 0.8 * t, 0.0}, 0.0, 0.0, 0.0};
  });
  EXPECT_EQ(start.failure, InitializationFailure::kTooLittleExcitation) << start.message;
  EXPECT_NE(start.message.find("change speed or direction"), std::string::npos) << start.message;
}

// All that accelerates is as constant as a bias may be; and the noise of distant points must not draw the scale to zero.
TEST(DynamicInitialization, ACarInABendHasNoScale) {
  Random random(5);
  const auto bend = [](const Jet& t) {
    return Coordinates{{20.0 * Cos(0.25 * t), 20.0 * Sin(0.25 * t), 0.0}, 0.25 * t, 0.0, 0.0};
  };
  const Recording recording =
      SimulateRecording(Trajectory(bend, 3.0), PointsOnPlanes(RoomWalls({-40, -40, -8}, {40, 40, 8}), 1500, &random));
  const DynamicInitialization start = InitializeDynamically(Cut(recording, 5, kImages, kStride), OptionsFor(recording));
  EXPECT_EQ(start.failure, InitializationFailure::kTooLittleExcitation) << start.message;
}

TEST(DynamicInitialization, AWrongExtrinsicIsNoticed) {
  const Recording recording = Fly(1, {});
  DynamicInitializationOptions options = OptionsFor(recording);
  options.T_B_C.q = options.T_B_C.q * ExpSO3(Vec3(0, 0, 1.5));
  EXPECT_NE(InitializeDynamically(Cut(recording, 50, kImages, kStride), options).failure, InitializationFailure::kNone);
}

TEST(DynamicInitialization, TooFewImagesOrTracks) {
  Recording recording = Fly(1, {});
  EXPECT_EQ(InitializeDynamically(Cut(recording, 50, 3, kStride), OptionsFor(recording)).failure,
            InitializationFailure::kTooFewFrames);
  EXPECT_EQ(InitializeDynamically({}, OptionsFor(recording)).failure, InitializationFailure::kTooFewFrames);
  auto frames = Cut(recording, 50, kImages, kStride);
  for (InitializationImage& frame : frames) frame.tracks.resize(std::min<size_t>(frame.tracks.size(), 5));
  const DynamicInitialization start = InitializeDynamically(frames, OptionsFor(recording));
  EXPECT_EQ(start.failure, InitializationFailure::kTooFewTracks) << start.message;
  frames[2].imu = nullptr;
  EXPECT_THROW(InitializeDynamically(frames, OptionsFor(recording)), std::invalid_argument);
}

// ---- the two steps ---------------------------------------------------------------------------------------------

std::vector<FeatureTrack> TracksOf(const std::vector<InitializationImage>& frames) {
  std::map<int, FeatureTrack> by_id;
  for (size_t k = 0; k < frames.size(); ++k) {
    for (const auto& point : frames[k].tracks) by_id[point.id].views.push_back({static_cast<int>(k), point.x});
  }
  std::vector<FeatureTrack> tracks;
  for (const auto& [id, track] : by_id) tracks.push_back(track);
  return tracks;
}

std::vector<Preintegration> ImuOf(const std::vector<InitializationImage>& frames) {
  std::vector<Preintegration> imu;
  for (size_t k = 1; k < frames.size(); ++k) imu.push_back(*frames[k].imu);
  return imu;
}

// All points on one plane, where eight-point algorithms fail: the bias is found all the same. With it, and without noise, the
// closed form finds the other bias, gravity and speed.
TEST(GyroscopeBias, IsFoundBeforeAPlane) {
  HandheldOptions handheld;
  handheld.duration = 4.0;
  Random random(6);
  SimulationOptions options;
  options.camera.pixel_sigma = 0.0;
  options.imu.noise_scale = 0.0;
  const Recording recording =
      SimulateRecording(Handheld(handheld),
                        PointsOnPlanes({{Vec3(6, -20, -10), Vec3(0, 40, 0), Vec3(0, 0, 20)}}, 3000, &random), options);
  const auto frames = Cut(recording, 10, kImages, kStride);
  std::vector<FeatureTrack> tracks = TracksOf(frames);
  std::vector<Preintegration> imu = ImuOf(frames);
  const Vec3 b_g = EstimateGyroscopeBias(recording.calibration.T_B_C.q, 1.0 / 460.0, &tracks, &imu);
  EXPECT_LT((b_g - recording.truth[0].b_g).norm(), 1e-4);
  EXPECT_EQ(imu.front().BiasGyroscope(), b_g);

  tracks.erase(std::remove_if(tracks.begin(), tracks.end(), [](const auto& t) { return t.views.size() < 6; }),
               tracks.end());
  ClosedFormOptions closed_form{recording.calibration.T_B_C};
  closed_form.b_a_sigma = 10.0;
  closed_form.sigma = 1e-5;
  const StampedState start = SolveClosedForm(tracks, imu, closed_form).states.front();
  const StampedState truth = *StateAt(recording.truth, frames.front().t);
  EXPECT_LT((start.b_a - truth.b_a).norm(), 3e-3) << "of 0.06 m/s²";
  EXPECT_LT((start.T_W_B.q.conjugate() * start.v_W - truth.T_W_B.q.conjugate() * truth.v_W).norm(), 1e-4);
}

// In a second, a turn looks like a shift: far from the bias there are other minima, which hold who begins at zero alone.
TEST(GyroscopeBias, IsFoundFarFromZero) {
  HandheldOptions path;
  path.duration = 12.0;
  for (path.seed = 1; path.seed <= 2; ++path.seed) {
    for (int axis = 0; axis < 3; ++axis) {
      SimulationOptions options;
      options.imu.b_g = 0.17 * Vec3::Unit(axis);
      options.camera.pixel_sigma = 0.05;
      options.camera.max_tracks = 100;
      const Recording recording = SimulateInRoom(path, 1500, options, path.seed);
      for (size_t first = 5; first + 20 < recording.images.size(); first += 13) {
        const auto frames = Cut(recording, first, 11, 2);
        std::vector<FeatureTrack> tracks = TracksOf(frames);
        std::vector<Preintegration> imu = ImuOf(frames);
        const Vec3 b_g = EstimateGyroscopeBias(recording.calibration.T_B_C.q, 1.5 / 460.0, &tracks, &imu);
        EXPECT_LT((b_g - StateAt(recording.truth, frames.front().t)->b_g).norm(), 5e-3)
            << "axis " << axis << ", seed " << path.seed << ", image " << first;
      }
    }
  }
}

// On the sphere ‖G‖ = g the gradient has no part along it but μG, and no point nearby is lower.
TEST(ClosedFormGravity, IsTheMinimumOnTheSphere) {
  Random random(8);
  for (int trial = 0; trial < 20; ++trial) {
    Eigen::Matrix<double, 9, 9> A;
    Vec9 b;
    for (int k = 0; k < 81; ++k) A.data()[k] = random.Normal();
    for (int k = 0; k < 9; ++k) b[k] = 10.0 * random.Normal();
    const Eigen::Matrix<double, 9, 9> H = A.transpose() * A;
    const auto cost = [&](const Vec9& x) { return 0.5 * x.dot(H * x) - b.dot(x); };
    const Vec9 x = SolveWithGravityNorm(H, b, 9.81);
    EXPECT_NEAR(x.segment<3>(3).norm(), 9.81, 1e-9);
    for (int other = 0; other < 200; ++other) {
      Vec9 y = x;
      for (int k = 0; k < 9; ++k) y[k] += (other % 2 ? 0.01 : 3.0) * random.Normal();
      y.segment<3>(3) *= 9.81 / y.segment<3>(3).norm();
      EXPECT_GE(cost(y), cost(x));
    }
  }
}

}  // namespace
}  // namespace ch5
