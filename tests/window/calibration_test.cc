/// What an estimator finds of its camera: the offset of its clock (VN19) and its rotation in the body.
#include <gtest/gtest.h>

#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/window/landmarks.h"
#include "tests/window/simulations.h"

namespace ch5 {
namespace {

// ---- the velocity of a point in the image ----------------------------------------------------------------------

// A track through images 100 ms apart, moving by (0.1, −0.2)/s, its image `disturbed` off by (0.01, 0.02).
WindowLandmark Track(int images, int disturbed = -1) {
  WindowLandmark landmark;
  for (int k = 0; k < images; ++k) {
    const Vec2 x = 0.1 * k * Vec2(0.1, -0.2) + (k == disturbed ? Vec2(0.01, 0.02) : Vec2(0, 0));
    AppendToTrack({k, 0.1 * k, x}, &landmark);
  }
  return landmark;
}

TEST(ImageVelocity, IsExactWhereTheMotionIsUniform) {
  for (int images = 2; images < 6; ++images) {
    for (const WindowObservation& seen : Track(images).seen) {
      EXPECT_LT((seen.velocity - Vec2(0.1, -0.2)).norm(), 1e-12) << images << " images, " << seen.frame;
    }
  }
}

// Else its noise would move the time offset, always in the same direction.
TEST(ImageVelocity, OfAnObservationDoesNotDependOnThatObservation) {
  for (int images = 3; images < 7; ++images) {
    for (int disturbed = 0; disturbed < images; ++disturbed) {
      const Vec2 velocity = Track(images, disturbed).seen[static_cast<size_t>(disturbed)].velocity;
      EXPECT_LT((velocity - Vec2(0.1, -0.2)).norm(), 1e-12) << disturbed << " of " << images;
    }
  }
}

TEST(ImageVelocity, OfATrackSeenOnceIsZero) { EXPECT_EQ(Track(1).seen[0].velocity, Vec2(0, 0)); }

// ---- one window at the truth -----------------------------------------------------------------------------------

// Perfect measurements, the poses where the body truly was at the images' stamps. Of twelve images the two at the ends
// only tell how fast the points of the others move.
TEST(TimeOffset, IsTheMinimumOfAWindowAtTheTruth) {
  constexpr int kImages = 12;
  for (const double late : {0.01, -0.01}) {
    RoomOptions room;
    room.duration = 4.0;
    room.standstill_seconds = 0.0;
    room.simulation.camera.pixel_sigma = 0.0;
    room.simulation.camera.time_offset = late;
    const Recording recording = SimulateRoom(room);
    Window window;
    window.extrinsic->SetPose(recording.calibration.T_B_C.q, recording.calibration.T_B_C.p);
    window.extrinsic->SetFixed();
    for (int k = 0; k < kImages; ++k) {
      const Image& image = recording.images[static_cast<size_t>(20 + k)];
      for (const TrackedPoint& point : image.tracks) AppendToTrack({k, image.t, point.x}, &window.landmarks[point.id]);
      const StampedState truth = *StateAt(recording.truth, image.t);
      Frame frame;
      frame.id = k;
      frame.pose = std::make_shared<VertexPose>(truth.T_W_B.q, truth.T_W_B.p);
      frame.pose->SetFixed();
      window.frames.push_back(frame);
    }
    ForgetObservations(0, DepthInCamera, &window);
    ForgetObservations(kImages - 1, DepthInCamera, &window);
    TriangulateLandmarks(&window);
    BuildGraph(
        {}, [](const Window&, const WindowLandmark& l) { return l.recent.images == kImages; }, &window);
    const Summary summary = SparseOptimizer(&window.graph).Solve();
    EXPECT_TRUE(IsConverged(summary.termination)) << summary.message;
    EXPECT_NEAR(window.time_offset->GetEstimate()[0], late, 3e-4);  // the flow is taken for straight over the offset
  }
}

// ---- whole runs ------------------------------------------------------------------------------------------------

// The calibration at the end of a run.
struct Found {
  double time_offset = 0.0;
  Qd R_B_C;
};

Found Calibrate(const Recording& recording, const EstimatorOptions& options, std::unique_ptr<WindowPolicy> policy) {
  Found found;
  const OdometryRun run =
      RunOdometry(recording, options, std::move(policy), [&](const Estimator& e, const ImageResult&) {
        found = {e.TimeOffset(), e.GetWindow().T_B_C().q};
      });
  EXPECT_EQ(run.restarts, 0);
  EXPECT_TRUE(run.error && run.error->position_rmse < 0.1);
  return found;
}

TEST(TimeOffset, OfTenMillisecondsIsFoundToOne) {
  for (const double late : {0.01, -0.01}) {
    RoomOptions room;
    room.simulation.camera.pixel_sigma = 0.5;
    room.simulation.camera.time_offset = late;
    const Recording recording = SimulateRoom(room);
    EstimatorOptions options{recording.calibration};
    options.estimate_time_offset = true;
    for (auto&& policy : AllPolicies()) {
      const std::string name = policy->Name();
      EXPECT_NEAR(Calibrate(recording, options, std::move(policy)).time_offset, late, 1e-3) << name;
    }
  }
}

// Rest, start and what is told of it are by the IMU's clock: stamps that are a second off, if that is known, change nothing.
TEST(TimeOffset, ThatIsKnownChangesNoEstimate) {
  const Recording recording = SimulateRoom();
  for (const double late : {1.0, -1.0}) {
    Recording shifted = recording;
    for (Image& image : shifted.images) image.t += late;
    EstimatorOptions options{recording.calibration}, other = options;
    other.time_offset = -late;
    for (size_t policy = 0; policy < 2; ++policy) {
      const OdometryRun expected = RunOdometry(recording, options, std::move(AllPolicies()[policy]));
      const OdometryRun run = RunOdometry(shifted, other, std::move(AllPolicies()[policy]));
      const std::string& name = run.policy;
      ASSERT_EQ(run.states.size(), expected.states.size()) << name << late;
      EXPECT_NEAR(run.states.front().t, expected.states.front().t, 1e-9) << name << late;
      EXPECT_LT((run.states.back().T_W_B.p - expected.states.back().T_W_B.p).norm(), 1e-3) << name << late;
      for (size_t k = 0; k < run.rows.size(); ++k)
        EXPECT_EQ(run.rows[k].report.scale_sigma.has_value(), expected.rows[k].report.scale_sigma.has_value())
            << name << late << " " << k;
    }
  }
}

// Noise of pixels, taken for noise of how fast they move, would hold an estimate at its start: 4 of 15 ms were found.
TEST(TimeOffset, IsFoundWherePointsMoveSlowlyAndPixelsAreNoisy) {
  for (const double late : {0.015, -0.015}) {
    HandheldOptions path;
    path.standstill_seconds = 2.0;
    path.knot_spacing = 2.0;
    path.yaw_step = 0.4;
    path.tilt_sigma = 0.1;
    SimulationOptions simulation;
    simulation.camera.pixel_sigma = 0.5;
    simulation.camera.time_offset = late;
    const Recording recording = SimulateInRoom(path, 1500, simulation);
    EstimatorOptions options{recording.calibration};
    options.estimate_time_offset = true;
    EXPECT_NEAR(Calibrate(recording, options, MakeVinsPolicy()).time_offset, late, 3e-3);
  }
}

TEST(StateCovariance, AnswersForAnyFreeVertexOfTheWindow) {
  const Recording recording = SimulateRoom({6.0});
  EstimatorOptions options{recording.calibration};
  options.estimate_time_offset = true;
  int compared = 0;
  options.detect_failure = [&](const Window& window, const auto&) {
    const auto variance = CovarianceOf(window, window.frames.back()).time_offset_variance;
    EXPECT_DOUBLE_EQ(CovarianceOf(window, *window.time_offset)(0, 0), variance.value());
    EXPECT_THROW(CovarianceOf(window, *window.extrinsic), CovarianceError);  // fixed
    ++compared;
    return Failure::kNone;
  };
  RunOdometry(recording, options, MakeVinsPolicy());
  EXPECT_GT(compared, 10);
}

TEST(Extrinsic, TwoDegreesAreFoundToThreeTenths) {
  for (const double standstill_seconds : {0.0, 2.0}) {
    const Recording recording = SimulateRoom({20.0, standstill_seconds});
    EstimatorOptions options{recording.calibration};
    const Qd truth = options.calibration.T_B_C.q;
    options.calibration.T_B_C.q = truth * ExpSO3(2.0 * kDegree * Vec3(1, -1, 1).normalized());
    options.estimate_extrinsic = true;
    for (auto&& policy : AllPolicies()) {
      const std::string name = policy->Name();
      const Found found = Calibrate(recording, options, std::move(policy));
      EXPECT_LT(found.R_B_C.angularDistance(truth), 0.3 * kDegree) << name << ", stood " << standstill_seconds << " s";
    }
  }
}

}  // namespace
}  // namespace ch5
