#include "ch5_backend/window/batch.h"

#include <gtest/gtest.h>

#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/experiments/studies/odometry_settings.h"
#include "ch5_backend/experiments/studies/odometry_study.h"

namespace ch5 {
namespace {

class Batch : public testing::Test {
 protected:
  Batch() {
    OdometrySettings settings;
    settings.to = 10.0;
    recording_ = SimulatedOdometryRecording();
    settings.Restrict(&recording_);
    const OdometryRun run = RunOdometry(recording_, EstimatorOptions{recording_.calibration}, MakeVinsPolicy());
    start_ = run.states;
    window_ = run.error.value();
    images_.assign(recording_.images.end() - static_cast<std::ptrdiff_t>(start_.size()), recording_.images.end());
  }
  BatchResult Solve(const BatchOptions& options = {}) const {
    return SolveBatch(EstimatorOptions{recording_.calibration}, images_, start_, recording_.imu, options);
  }

  Recording recording_;
  std::vector<Image> images_;
  std::vector<StampedState> start_;
  TrajectoryError window_;
};

TEST_F(Batch, IsNearerToTheTruthThanTheWindowItStartsFrom) {
  const BatchResult batch = Solve();
  ASSERT_EQ(batch.states.size(), start_.size());
  EXPECT_LT(CompareTrajectories(batch.states, recording_.truth)->position_rmse, window_.position_rmse);
}

TEST_F(Batch, EndsAtTheSamePlaceFromAScaledStart) {
  const BatchResult batch = Solve();
  for (StampedState& state : start_) {
    state.T_W_B.p *= 1.05;
    state.v_W *= 1.05;
  }
  const TrajectoryError apart = CompareTrajectories(Solve().states, batch.states).value();
  EXPECT_LT(apart.position_rmse, 2e-3);
  EXPECT_NEAR(apart.scale, 1.0, 2e-3);
}

TEST_F(Batch, SaysWhatIsMissing) {
  start_.pop_back();
  EXPECT_THROW(Solve(), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
