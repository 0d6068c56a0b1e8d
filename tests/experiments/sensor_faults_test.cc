#include "ch5_backend/experiments/studies/sensor_faults.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/window/simulations.h"

namespace ch5 {
namespace {

Recording Walk() {
  RoomOptions options;
  options.simulation.camera.pixel_sigma = 0.5;
  return SimulateRoom(options);
}

// What is said, and the recording as it is then.
std::pair<RecordingWarnings, Recording> Corrected(Recording recording) {
  OdometrySettings settings;
  settings.policy = "vins";
  const RecordingWarnings warnings =
      CorrectFaults(RunOdometryStudy(recording, nullptr, settings), settings, &recording);
  return {warnings, recording};
}

// RMS over the readings but the first and last [m/s²].
double ForceApart(const Recording& a, const Recording& b) {
  constexpr size_t kEnds = 20;
  double squares = 0.0;
  for (size_t k = kEnds; k + kEnds < a.imu.size(); ++k)
    squares += (a.imu[k].acceleration - b.imu[k].acceleration).squaredNorm();
  return std::sqrt(squares / static_cast<double>(a.imu.size() - 2 * kEnds));
}

TEST(SensorFaults, NothingIsSaidOfARecordingInOrder) {
  const Recording walk = Walk();
  const auto [warnings, now] = Corrected(walk);
  EXPECT_TRUE(warnings.empty()) << warnings[0].words;
  EXPECT_EQ(ForceApart(walk, now), 0.0);
}

TEST(SensorFaults, AnAxisThatIsTooLongIsNamedAndShortened) {
  const Recording walk = Walk();
  Recording damaged = walk;
  for (ImuMeasurement& m : damaged.imu) m.acceleration.y() *= 1.08;
  const auto [warnings, now] = Corrected(damaged);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].name, "accelerometer_scale");
  EXPECT_EQ(warnings[0].detail, "y");
  EXPECT_NEAR(warnings[0].value, 1.08, 0.01);
  EXPECT_LT(ForceApart(walk, now), 0.2 * ForceApart(walk, damaged));
}

TEST(SensorFaults, AnAccelerometerThatIsLateOrEarlyIsNamedAndMoved) {
  for (const int readings : {8, -5}) {  // of 5 ms
    const Recording walk = Walk();
    Recording damaged = walk;
    const int n = static_cast<int>(walk.imu.size());
    for (int k = 0; k < n; ++k)
      damaged.imu[static_cast<size_t>(k)].acceleration =
          walk.imu[static_cast<size_t>(std::clamp(k - readings, 0, n - 1))].acceleration;
    const auto [warnings, now] = Corrected(damaged);
    ASSERT_EQ(warnings.size(), 1U) << readings;
    EXPECT_EQ(warnings[0].name, readings > 0 ? "accelerometer_late" : "accelerometer_early");
    EXPECT_NEAR(warnings[0].value, 5.0 * std::abs(readings), 2.0);
    EXPECT_LT(ForceApart(walk, now), 0.5 * ForceApart(walk, damaged));
  }
}

TEST(SensorFaults, StampsThatJitterAreMadeEven) {
  constexpr double kJitter = 7e-3;
  const Recording walk = Walk();
  Recording damaged = walk;
  std::mt19937_64 random(1);
  std::normal_distribution<double> jitter(0.0, kJitter);
  for (Image& image : damaged.images) image.t += std::clamp(jitter(random), -0.02, 0.02);
  const auto [warnings, now] = Corrected(damaged);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].name, "stamps_even");
  EXPECT_NEAR(warnings[0].value, 1e3 * kJitter, 2.5);
  double squares = 0.0;
  for (size_t k = 0; k < now.images.size(); ++k) squares += std::pow(now.images[k].t - walk.images[k].t, 2);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(now.images.size())), 0.4 * kJitter);
}

// A camera that is triggered as it likes: its stamps are right, and no even ones are taken for them.
TEST(SensorFaults, ImagesAtUnevenTimesStayAsTheyAre) {
  Recording walk = Walk();
  std::vector<Image> kept;
  for (size_t k = 0; k < walk.images.size(); ++k)
    if (k % 7 != 2 && k % 11 != 4) kept.push_back(walk.images[k]);
  walk.images = kept;
  const auto [warnings, now] = Corrected(walk);
  EXPECT_TRUE(warnings.empty()) << warnings[0].words;
}

}  // namespace
}  // namespace ch5
