#include "ch5_backend/experiments/studies/clock_check.h"

#include <gtest/gtest.h>

#include "ch5_backend/experiments/studies/odometry_study.h"
#include "ch5_backend/experiments/studies/recording_warnings.h"
#include "ch5_backend/experiments/studies/turn_warnings.h"
#include "ch5_backend/simulate/sensors/simulation.h"

namespace ch5 {
namespace {

// Seen at 1 px or less, and briskly moved, points tell the delay.
Recording Delayed(double seconds, double pixels = 0.3, int tracks = 50) {
  SimulationOptions options;
  options.camera.pixel_sigma = pixels;
  options.camera.max_tracks = tracks;
  Recording recording = SimulateInRoom({10.0}, 1000, options, 3);
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

}  // namespace
}  // namespace ch5
