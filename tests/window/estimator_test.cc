/// The estimators on simulated recordings, against the truth.
#include <gtest/gtest.h>

#include "tests/window/simulations.h"

namespace ch5 {
namespace {

void ExpectSmallErrors(const Recording& recording, const OdometryRun& run, double most_metres) {
  ASSERT_TRUE(run.error);
  EXPECT_LT(run.error->position_rmse, most_metres);
  EXPECT_NEAR(run.error->scale, 1.0, 0.01);
  EXPECT_LT(run.error->yaw_rmse, 0.01);
  EXPECT_EQ(run.restarts, 0);
  EXPECT_GT(run.states.back().t, recording.frames.back().t - 1e-6) << "it must answer to the end";
}

TEST(Estimator, VinsFollowsAHandHeldCamera) {
  const Recording recording = SimulateRoom();
  const OdometryRun run = RunOdometry(recording, OptionsFor(recording.calibration), MakeVinsPolicy());
  ExpectSmallErrors(recording, run, 0.05);
  RecordProperty("ate_mm", static_cast<int>(1e3 * run.error->position_rmse));
}

}  // namespace
}  // namespace ch5
