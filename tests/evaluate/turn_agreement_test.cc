#include "ch5_backend/evaluate/turn_agreement.h"

#include <cmath>

#include <gtest/gtest.h>

#include "ch5_backend/simulate/sensors/scene_points.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

// A hand-held camera that turns on the spot, so that its images tell the turns alone, unless it walks too.
Recording Turning(double time_offset, double position_sigma = 0.02) {
  HandheldOptions path;
  path.duration = 10.0;
  path.position_sigma = position_sigma;
  SimulationOptions options;
  options.camera.time_offset = time_offset;
  options.camera.outlier_fraction = 0.05;
  return SimulateInRoom(path, 1000, options, 1);
}

TEST(TurnAgreement, FindsTheDelayOfTheCamerasClock) {
  for (const double delay : {0.0, 0.05, -0.12}) {
    const auto turns = CompareTurns(Turning(delay));
    ASSERT_TRUE(turns);
    EXPECT_NEAR(turns->delay, delay, 0.011) << "a step of its search";
    EXPECT_GT(turns->at_delay, 0.99);
    EXPECT_EQ(turns->as_given < turns->at_delay, delay != 0.0);
  }
}

// A second is within the search; of three the turns must not pass for ones that agree.
TEST(TurnAgreement, ADelayOfASecondIsFoundAndALongerOneIsDoubted) {
  for (const double late : {0.0, 1.0, -1.0, 3.0}) {
    Recording recording = Turning(0.0);
    for (Image& image : recording.images) image.t += late;
    const auto turns = CompareTurns(recording);
    ASSERT_TRUE(turns);
    const auto delay = ClearDelay(*turns);
    EXPECT_EQ(delay.has_value(), std::abs(late) == 1.0) << late;
    if (delay) {
      EXPECT_NEAR(*delay, -late, 0.011);
    }
    EXPECT_EQ(TurnOtherwise(*turns), late == 3.0) << late << ": " << turns->as_given;
  }
}

// How a walk moves points of different depths must not pass for turns: the delay would not stand out.
TEST(TurnAgreement, TellsTurnsFromWalking) {
  for (const double delay : {0.0, 0.03, -0.03}) {
    const auto turns = CompareTurns(Turning(delay, 0.9));
    ASSERT_TRUE(turns);
    EXPECT_NEAR(turns->delay, delay, 0.011);
    EXPECT_EQ(ClearDelay(*turns).has_value(), delay != 0.0) << "delayed by " << delay;
  }
}

// The variance that is left falls from 0.0424 to 0.04: as a delay of 20 ms has it, and as noise that looks like one of 60 ms.
TEST(TurnAgreement, ALongDelayMustGainMore) {
  TurnAgreement turns;
  turns.as_given = std::sqrt(1.0 - 0.0424);
  turns.at_delay = std::sqrt(1.0 - 0.04);
  turns.pairs = 1000.0;
  for (const double delay : {0.02, -0.02, 0.04, 0.06, -0.06, 0.2}) {
    turns.delay = delay;
    EXPECT_EQ(ClearDelay(turns).has_value(), std::abs(delay) < 0.05) << delay;
  }
}

// At 10 m/s along a narrow road, all points lie ahead, and a turn looks much like a shift.
TEST(TurnAgreement, DoesNotBlameACarWhoseImagesHardlyTellTurns) {
  const Trajectory road(
      [](const Jet& t) {
        const auto constant = [](double x) { return Jet{x, 0.0, 0.0}; };
        const Jet angle = constant(0.4) * t, yaw = constant(0.2) * Sin(angle);
        return Coordinates{{constant(10.0) * t, constant(5.0) * (constant(1.0) - Cos(angle)), {}}, yaw, {}, {}};
      },
      30.0);
  Random random(1);
  const auto points = PointsOnPlanes(RoomWalls(Vec3(-20, -8, -1), Vec3(400, 18, 8)), 6000, &random);
  auto turns = CompareTurns(SimulateRecording(road, points, {}));
  ASSERT_TRUE(turns);
  EXPECT_GT(turns->noise, 6.0);
  turns->at_delay = 0.3;
  EXPECT_FALSE(TurnOtherwise(*turns));
  turns->noise = CompareTurns(Turning(0.0, 0.9))->noise;
  EXPECT_TRUE(TurnOtherwise(*turns));
}

TEST(TurnAgreement, FindsAnInvertedExtrinsicRotation) {
  Recording recording = Turning(0.0);
  Qd& q_B_C = recording.calibration.T_B_C.q;
  ASSERT_GT(q_B_C.angularDistance(q_B_C.conjugate()), 1.0);
  q_B_C = q_B_C.conjugate();
  const auto turns = CompareTurns(recording);
  EXPECT_LT(turns->at_delay, 0.7);
  EXPECT_GT(turns->with_inverse, 0.99);
}

TEST(TurnAgreement, FindsTheGyroscopesAxes) {
  const std::vector<Mat33> all = SignedPermutations();
  EXPECT_EQ(all.size(), 48u);
  EXPECT_EQ(all[0], Mat33::Identity());
  for (const size_t k : {0, 7, 13, 42}) {
    Recording recording = Turning(0.0);
    for (ImuMeasurement& measurement : recording.imu)
      measurement.gyroscope = all[k].transpose() * measurement.gyroscope;
    const auto turns = CompareTurns(recording);
    ASSERT_TRUE(turns);
    EXPECT_EQ(turns->axes, all[k]);
    EXPECT_GT(turns->with_axes, 0.99);
    EXPECT_EQ(turns->as_given < 0.9, k != 0);
  }
}

TEST(TurnAgreement, FindsTracksOfAMirroredImage) {
  Recording recording = Turning(0.0);
  for (Image& image : recording.images)
    for (TrackedPoint& point : image.tracks) point.x = Vec2(point.x.y(), point.x.x());
  const auto turns = CompareTurns(recording);
  EXPECT_LT(turns->as_given, 0.9);
  EXPECT_EQ(turns->tracks, "y, x");
  EXPECT_GT(turns->with_tracks, 0.99);
}

TEST(TurnAgreement, ASlowImuIsNoDelay) {
  Recording recording = Turning(0.0);
  std::vector<ImuMeasurement> slow;
  for (size_t k = 0; k < recording.imu.size(); k += 10) slow.push_back(recording.imu[k]);
  recording.imu = slow;
  EXPECT_NEAR(CompareTurns(recording)->delay, 0.0, 0.011) << "of 20 Hz";
}

TEST(TurnAgreement, SaysNothingOfACameraThatHardlyTurns) {
  Recording recording = Turning(0.0);
  for (ImuMeasurement& measurement : recording.imu) measurement.gyroscope *= 0.01;
  EXPECT_FALSE(CompareTurns(recording));
  EXPECT_FALSE(CompareTurns({}));
}

}  // namespace
}  // namespace ch5
