/// The estimators on simulated recordings, against the truth.
#include <gtest/gtest.h>

#include <filesystem>

#include "ch5_backend/files/recording_file.h"
#include "tests/window/simulations.h"

namespace ch5 {
namespace {

void ExpectSmallErrors(const Recording& recording, const OdometryRun& run, double most_meters) {
  ASSERT_TRUE(run.error);
  EXPECT_LT(run.error->position_rmse, most_meters);
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

TEST(Estimator, OkvisFollowsAHandHeldCamera) {
  const Recording recording = SimulateRoom();
  OkvisOptions options;
  options.temporal_frames = 5;
  const OdometryRun run = RunOdometry(recording, OptionsFor(recording.calibration), MakeOkvisPolicy(options));
  ExpectSmallErrors(recording, run, 0.10);
}

// The numbers that the recording must give: ATE over everything after the start, both policies.
TEST(Estimator, BothPoliciesFollowARealDrone) {
  const std::filesystem::path folder = std::filesystem::path(CH5_DATA_DIR) / "euroc_v1_01_easy";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder << "; set CH5_DATA_DIR";
  const Recording recording = ReadRecording(folder);
  for (auto&& policy : AllPolicies(recording.calibration)) {
    const OdometryRun run = RunOdometry(recording, OptionsFor(recording.calibration), std::move(policy));
    SCOPED_TRACE(run.policy);
    ASSERT_TRUE(run.error);
    EXPECT_LT(run.error->position_rmse, 0.10);
    EXPECT_GT(run.states.size(), 480u);
    EXPECT_EQ(run.restarts, 0);
  }
}

TEST(Estimator, RefusesTimesThatDoNotIncrease) {
  Estimator estimator(EstimatorOptions{}, MakeVinsPolicy());
  estimator.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()});
  EXPECT_THROW(estimator.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()}), MeasurementError);
  EXPECT_THROW(estimator.AddImu({0.5, Vec3(0, 0, 9.81), Vec3::Zero()}), MeasurementError);
  EXPECT_THROW(estimator.AddImu({2.0, Vec3(0, 0, NAN), Vec3::Zero()}), MeasurementError);
  estimator.AddFrame({1.0, {}});
  EXPECT_THROW(estimator.AddFrame({1.0, {}}), MeasurementError);
  EXPECT_THROW(estimator.AddFrame({0.9, {}}), MeasurementError);
  estimator.AddImu({1.1, Vec3(0, 0, 9.81), Vec3::Zero()});
  EXPECT_NO_THROW(estimator.AddFrame({1.05, {}}));
}

TEST(MeasurementChecks, GapsBeforeBetweenAndAfterReadingsCount) {
  const auto at = [](std::initializer_list<double> times) {
    std::vector<ImuMeasurement> imu;
    for (const double t : times) imu.push_back({t, Vec3(0, 0, 9.81), Vec3::Zero()});
    return imu;
  };
  EXPECT_TRUE(HasImuGap({}, 0.0, 0.05, 0.1));
  EXPECT_FALSE(HasImuGap(at({0.0, 0.1, 0.2}), 0.0, 0.25, 0.11));
  EXPECT_TRUE(HasImuGap(at({0.15, 0.2}), 0.0, 0.2, 0.11)) << "before";
  EXPECT_TRUE(HasImuGap(at({0.0, 0.2}), 0.0, 0.2, 0.11)) << "between";
  EXPECT_TRUE(HasImuGap(at({0.0, 0.1}), 0.0, 0.25, 0.11)) << "after";
  EXPECT_TRUE(HasImuGap(at({0.0, 0.1, 0.5}), 0.0, 0.15, 0.11)) << "around the end";
}

TEST(MeasurementChecks, ARepeatedTrackIsNamed) {
  try {
    CheckImage({1.0, {{3, Vec2(0, 0)}, {7, Vec2(0, 0)}, {3, Vec2(0.1, 0)}}}, 0.5);
    FAIL();
  } catch (const MeasurementError& error) {
    EXPECT_STREQ(error.what(), "track 3 stands twice in the image at t = 1.000000 s");
  }
}

}  // namespace
}  // namespace ch5
