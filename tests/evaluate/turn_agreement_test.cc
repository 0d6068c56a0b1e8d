#include "ch5_backend/evaluate/turn_agreement.h"

#include <gtest/gtest.h>

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

// How a walk moves points of different depths must not pass for turns: the delay would not stand out.
TEST(TurnAgreement, TellsTurnsFromWalking) {
  for (const double delay : {0.0, 0.03, -0.03}) {
    const auto turns = CompareTurns(Turning(delay, 0.9));
    ASSERT_TRUE(turns);
    const auto left = [](double correlation) { return 1.0 - correlation * correlation; };
    const double gain = left(turns->as_given) / left(turns->at_delay);
    EXPECT_NEAR(turns->delay, delay, 0.011);
    EXPECT_EQ(gain > 1.05, delay != 0.0) << gain << ", delayed by " << delay;
  }
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

TEST(TurnAgreement, SaysNothingOfACameraThatHardlyTurns) {
  Recording recording = Turning(0.0);
  for (ImuMeasurement& measurement : recording.imu) measurement.gyroscope *= 0.01;
  EXPECT_FALSE(CompareTurns(recording));
  EXPECT_FALSE(CompareTurns({}));
}

}  // namespace
}  // namespace ch5
