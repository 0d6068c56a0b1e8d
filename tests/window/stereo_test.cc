/// A second camera: the same landmarks in both, scale from the first image, both extrinsics estimated.
#include <gtest/gtest.h>

#include <algorithm>

#include "ch5_backend/math/median.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/window/batch.h"
#include "ch5_backend/window/landmarks.h"
#include "tests/temporary_folder.h"
#include "tests/window/simulations.h"

namespace ch5 {
namespace {

// A gentle flight, whose accelerations say little of the scale; two seconds at rest before it.
Recording GentleStereoFlight(double duration) {
  HandheldOptions path;
  path.duration = duration;
  path.standstill_seconds = 2.0;
  path.position_sigma = 0.27;
  path.yaw_step = 0.15;
  path.tilt_sigma = 0.075;
  SimulationOptions simulation;
  simulation.calibration = ForwardStereo();
  simulation.camera.max_tracks = 60;
  simulation.camera.pixel_sigma = 0.5;
  return SimulateInRoom(path, 1500, simulation);
}

Recording WithOneCamera(Recording recording) {
  recording.calibration.camera1.reset();
  for (Image& image : recording.images) image.tracks1.clear();
  return recording;
}

TEST(Stereo, IsNearerToTheTruthThanOneCameraOnAGentleFlight) {
  const Recording stereo = GentleStereoFlight(12.0), mono = WithOneCamera(stereo);
  auto policies = AllPolicies(), again = AllPolicies();
  for (size_t k = 0; k < policies.size(); ++k) {
    const OdometryRun two = RunOdometry(stereo, EstimatorOptions{stereo.calibration}, std::move(policies[k]));
    const OdometryRun one = RunOdometry(mono, EstimatorOptions{mono.calibration}, std::move(again[k]));
    SCOPED_TRACE(two.policy);
    ASSERT_TRUE(one.error && two.error);
    EXPECT_EQ(two.restarts, 0);
    EXPECT_LT(two.error->position_rmse, 0.02);
    EXPECT_LT(two.error->position_rmse, one.error->position_rmse);
    EXPECT_NEAR(two.error->scale, 1.0, 0.01);
    EXPECT_LT(two.states.front().t, 0.5) << "it starts at rest";
    EXPECT_GT(one.states.front().t, 2.0) << "one camera waits for motion";
    for (const auto& [run, name] : {std::pair(&one, "one"), std::pair(&two, "two")}) {
      RecordProperty(two.policy + "_" + name + "_ate_mm_10", static_cast<int>(1e4 * run->error->position_rmse));
      RecordProperty(two.policy + "_" + name + "_scale_1e4", static_cast<int>(1e4 * run->error->scale));
    }
  }
}

// Three seconds at rest: depths in meters, and a body that stays where it is.
TEST(Stereo, StartsAtRestWithTheScaleOfItsBaseLine) {
  Recording recording = GentleStereoFlight(4.0);
  const auto in_motion = [](const Image& image) { return image.t > 1.9; };
  recording.images.erase(std::find_if(recording.images.begin(), recording.images.end(), in_motion),
                         recording.images.end());
  for (auto&& policy : AllPolicies()) {
    Snapshot last;
    const OdometryRun run = RunOdometry(recording, EstimatorOptions{recording.calibration}, std::move(policy),
                                        [&](const Estimator& e, const ImageResult&) { last = e.TakeSnapshot(); });
    SCOPED_TRACE(run.policy);
    ASSERT_GT(run.states.size(), 25u);
    EXPECT_LT((run.states.back().T_W_B.p - run.states.front().T_W_B.p).norm(), 0.02);
    EXPECT_LT(run.states.back().v_W.norm(), 0.02);
    ASSERT_TRUE(last.T_B_C1 && last.landmarks.size() > 20);
    // Depth times disparity is the base line.
    std::vector<double> ratios;
    const auto& newest = recording.images.back();
    for (const auto& landmark : last.landmarks) {
      const auto is_it = [&](const TrackedPoint& point) { return point.id == landmark.track; };
      const auto left = std::find_if(newest.tracks.begin(), newest.tracks.end(), is_it);
      const auto right = std::find_if(newest.tracks1.begin(), newest.tracks1.end(), is_it);
      if (left == newest.tracks.end() || right == newest.tracks1.end()) continue;
      const Transform& T_W_B = last.frames.back().state.T_W_B;
      const Transform T_W_C = {T_W_B.q * last.T_B_C.q, T_W_B.q * last.T_B_C.p + T_W_B.p};
      ratios.push_back(DepthInCamera(T_W_C, landmark.p_W) * (left->x.x() - right->x.x()) / 0.11);
    }
    ASSERT_GT(ratios.size(), 20u);
    EXPECT_NEAR(Median(ratios), 1.0, 0.03);
  }
}

TEST(Stereo, ExtrinsicsOffByTwoDegreesAndTwoCentimetersConverge) {
  RoomOptions room;
  room.simulation.calibration = ForwardStereo();
  room.standstill_seconds = 0.0;
  const Recording recording = SimulateRoom(room);
  EstimatorOptions options{recording.calibration};
  const Transform truth0 = options.calibration.T_B_C, truth1 = options.calibration.camera1->T_B_C;
  options.calibration.T_B_C.q = truth0.q * ExpSO3(2.0 * kDegree * Vec3(1, -1, 1).normalized());
  options.calibration.T_B_C.p += 0.02 * Vec3(1, 1, -1).normalized();
  options.calibration.camera1->T_B_C.q = truth1.q * ExpSO3(2.0 * kDegree * Vec3(-1, 1, 1).normalized());
  options.calibration.camera1->T_B_C.p += 0.02 * Vec3(1, -1, 1).normalized();
  options.estimate_extrinsic = true;
  for (auto&& policy : AllPolicies()) {
    Snapshot last;
    const OdometryRun run = RunOdometry(recording, options, std::move(policy),
                                        [&](const Estimator& e, const ImageResult&) { last = e.TakeSnapshot(); });
    SCOPED_TRACE(run.policy);
    ASSERT_TRUE(run.error && last.T_B_C1);
    EXPECT_EQ(run.restarts, 0);
    EXPECT_LT(run.error->position_rmse, 0.08);
    EXPECT_LT(last.T_B_C.q.angularDistance(truth0.q), 0.2 * kDegree);
    EXPECT_LT(last.T_B_C1->q.angularDistance(truth1.q), 0.2 * kDegree);
    EXPECT_LT((last.T_B_C1->p - last.T_B_C.p - (truth1.p - truth0.p)).norm(), 0.008) << "the base line";
  }
}

// The extrinsics are not expressed in the world: neither turns with its gauge.
TEST(Stereo, ObservabilityConstraintsHoldBesideBothExtrinsics) {
  const Recording recording = GentleStereoFlight(6.0);
  EstimatorOptions options{recording.calibration};
  options.estimate_extrinsic = true;
  options.observability_constraints = ObservabilityConstraints::kAllEdges;
  for (auto&& policy : AllPolicies()) {
    const OdometryRun run = RunOdometry(recording, options, std::move(policy));
    ASSERT_TRUE(run.error) << run.policy;
    EXPECT_LT(run.error->position_rmse, 0.06) << run.policy;
    EXPECT_EQ(run.restarts, 0) << run.policy;
  }
}

TEST(Stereo, ABatchUsesBothCameras) {
  Recording recording = GentleStereoFlight(4.0);
  const OdometryRun run = RunOdometry(recording, EstimatorOptions{recording.calibration}, MakeVinsPolicy());
  const std::vector<Image> images(recording.images.end() - static_cast<std::ptrdiff_t>(run.states.size()),
                                  recording.images.end());
  const BatchResult batch = SolveBatch(EstimatorOptions{recording.calibration}, images, run.states, recording.imu);
  const auto error = CompareTrajectories(batch.states, recording.truth);
  ASSERT_TRUE(error && batch.T_B_C1);
  EXPECT_LT(error->position_rmse, 0.01);
}

// ---- one camera ------------------------------------------------------------------------------------------------

// Neither a camera that sees nothing, nor points of a camera that nobody calibrated.
TEST(Stereo, WithoutASecondCameraNoBitChanges) {
  const Recording stereo = GentleStereoFlight(6.0), mono = WithOneCamera(stereo);
  Recording blind = mono, uncalibrated = stereo;
  blind.calibration.camera1 = stereo.calibration.camera1;
  uncalibrated.calibration.camera1.reset();
  for (size_t k = 0; k < 2; ++k) {
    const auto run = [&](const Recording& recording) {
      return RunOdometry(recording, EstimatorOptions{recording.calibration}, std::move(AllPolicies()[k]));
    };
    const OdometryRun one = run(mono);
    ASSERT_GE(one.states.size(), 40u);
    EXPECT_TRUE(AreSame(one.states, run(blind).states)) << one.policy;
    EXPECT_TRUE(AreSame(one.states, run(uncalibrated).states)) << one.policy;
  }
}

TEST(Stereo, APointOfCameraOneIsCheckedToo) {
  Estimator estimator(EstimatorOptions{ForwardStereo()}, MakeVinsPolicy());
  const Image twice{1.0, {{7, Vec2(0, 0)}}, {{7, Vec2(0, 0)}, {7, Vec2(1, 0)}}};
  EXPECT_EQ(test::Refusal<MeasurementError>([&] { estimator.AddFrame(twice); }),
            "track 7 stands twice in camera 1's image at t = 1.000000 s");
}

// A third of camera 1's points lie 40 px beside their own, the whole track long.
TEST(Stereo, AFalseMatchInCameraOneCostsItsViewsThereAlone) {
  const Recording clean = GentleStereoFlight(8.0);
  Recording wrong = clean;
  for (Image& image : wrong.images) {
    for (TrackedPoint& point : image.tracks1) {
      if (point.id % 3 == 0) point.x += Vec2(0, 40.0 / clean.calibration.FocalLength());
    }
  }
  auto policies = AllPolicies(), again = AllPolicies();
  for (size_t k = 0; k < policies.size(); ++k) {
    const OdometryRun with = RunOdometry(wrong, EstimatorOptions{wrong.calibration}, std::move(policies[k]));
    const OdometryRun without = RunOdometry(clean, EstimatorOptions{clean.calibration}, std::move(again[k]));
    SCOPED_TRACE(with.policy);
    ASSERT_TRUE(with.error && without.error);
    EXPECT_EQ(with.restarts, 0);
    EXPECT_LT(with.error->position_rmse, 2.0 * without.error->position_rmse);
    const auto landmarks = [](const OdometryRun& run) {
      double sum = 0.0;
      for (const ImageResult& row : run.rows) sum += row.report.landmarks;
      return sum / static_cast<double>(run.rows.size());
    };
    EXPECT_GT(landmarks(with), 0.85 * landmarks(without));
  }
}

TEST(Stereo, NoisyHostsAreForOneCamera) {
  EstimatorOptions options{ForwardStereo()};
  options.weights.noisy_hosts = true;
  EXPECT_THROW(options.Validate(), OptionError);
}

}  // namespace
}  // namespace ch5
