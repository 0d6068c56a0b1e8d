#include "ch5_backend/experiments/studies/clock_check.h"

#include <gtest/gtest.h>

#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/experiments/studies/recording_warnings.h"
#include "ch5_backend/experiments/studies/turn_warnings.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "tests/experiments/warning_names.h"

namespace ch5 {
namespace {

// Seen at 1 px or less, and briskly moved, points tell the delay.
Recording Delayed(double seconds, double pixels = 0.3, int tracks = 50, double duration = 10.0) {
  SimulationOptions options;
  options.camera.pixel_sigma = pixels;
  options.camera.max_tracks = tracks;
  Recording recording = SimulateInRoom({duration}, 1000, options, 3);
  for (Image& image : recording.images) image.t += seconds;
  return recording;
}

TEST(ClockCheck, DelaysStandOutFromTheirError) {
  for (const double late : {0.005, 0.3}) {
    const auto clock = EstimateClockOffset(Delayed(late), {}, std::trunc(-late / 0.01) * 0.01);
    ASSERT_TRUE(clock) << late;
    EXPECT_NEAR(clock->offset, -late, 3.0 * clock->sigma) << late;
    EXPECT_TRUE(IsDecided(*clock)) << late << ": " << clock->offset << " ± " << clock->sigma;
  }
}

// Then noise holds the estimates at their guess, and what they agree about is not the delay.
TEST(ClockCheck, NoiseDoesNotPassForAnAnswer) {
  for (const double guess : {0.0, -0.01}) {
    const auto clock = EstimateClockOffset(Delayed(0.005, 2.0, 30), {}, guess);
    EXPECT_TRUE(!clock || std::abs(clock->offset + 0.005) < 3.0 * clock->sigma) << guess;
  }
}

TEST(ClockCheck, ADelayIsFoundAndSetUnlessTheUserHasDecided) {
  for (const char* decided : {"", "false"}) {
    Recording recording = Delayed(0.3);
    OdometrySettings settings;
    if (*decided) settings.Set("estimate_time_offset", decided);
    CheckMeasurements(&settings, &recording);
    const RecordingWarnings warnings = CheckClock(recording, &settings);
    EXPECT_EQ(warnings.size(), *decided ? 0u : 1u);
    EXPECT_NEAR(settings.estimator.time_offset, *decided ? 0.0 : -0.3, 0.002) << decided;
  }
}

TEST(ClockCheck, ClocksThatAgreeStayAsTheyAre) {
  Recording recording = Delayed(0.0);
  OdometrySettings settings;
  EXPECT_TRUE(CheckMeasurements(&settings, &recording).empty());
  EXPECT_TRUE(CheckClock(recording, &settings).empty());
  EXPECT_EQ(settings.estimator.time_offset, 0.0);
}

// One clock runs fast, or is set forth or back; of the IMU's 0.3 s that come twice, the second is left out by the reader.
TEST(ClockCheck, ADelayThatChangesIsNamedAndEvenedOut) {
  const Recording healthy = Delayed(0.0, 0.3, 50, 30.0);
  ASSERT_FALSE(CompareTurns(healthy)->change);
  struct Case {
    double rate, imu_jump, image_jump;
  };
  for (const auto& [rate, imu_jump, image_jump] : {Case{0.002, 0.0, 0.0}, Case{-0.005, 0.0, 0.0}, Case{0.0, 0.5, 0.0},
                                                   Case{0.0, -0.3, 0.0}, Case{0.0, 0.0, 0.1}}) {
    Recording recording;
    recording.calibration = healthy.calibration;
    recording.images = healthy.images;
    for (Image& image : recording.images)
      if (image.t > 15.0) image.t += image_jump;
    for (ImuMeasurement m : healthy.imu) {
      m.t = (1.0 + rate) * m.t + (m.t > 15.0 ? imu_jump : 0.0);
      if (recording.imu.empty() || m.t > recording.imu.back().t) recording.imu.push_back(m);
    }
    OdometrySettings settings;
    const RecordingWarnings warnings = CheckMeasurements(&settings, &recording);
    ASSERT_EQ(Names(warnings), rate != 0.0 ? "clock_rate" : "delay_jump")
        << rate << " " << imu_jump << " " << image_jump;
    EXPECT_NEAR(warnings[0].value, rate != 0.0 ? 100.0 * rate : 1e3 * (imu_jump - image_jump), 4.0 * warnings[0].other);
    const auto turns = CompareTurns(recording);
    EXPECT_LT(std::abs(turns->delay), 0.011);
    EXPECT_GT(turns->at_delay, CompareTurns(healthy)->at_delay - 0.01);
  }
}

}  // namespace
}  // namespace ch5
