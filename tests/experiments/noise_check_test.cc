#include "ch5_backend/experiments/studies/noise_check.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"
#include "tests/experiments/warning_names.h"
#include "tests/window/simulations.h"

namespace ch5 {
namespace {

Recording Noisy(double pixels, double imu = 1.0, double outliers = 0.0, double rate = 200.0) {
  RoomOptions options;
  options.duration = 12.0;
  options.simulation.camera.pixel_sigma = pixels;
  options.simulation.camera.outlier_fraction = outliers;
  options.simulation.imu.noise_scale = imu;
  options.simulation.calibration.imu_rate = rate;
  return SimulateRoom(options);
}

TEST(NoiseCheck, NoiseOfTracksIsMeasured) {
  for (const double pixels : {0.3, 1.0, 2.0, 3.0}) {
    const auto noise = NoiseOfTracks(Noisy(pixels));
    ASSERT_TRUE(noise);
    EXPECT_NEAR(noise->value / pixels, 1.0, 0.1);
    EXPECT_LT(noise->sigma, 0.05 * pixels);
  }
  EXPECT_NEAR(NoiseOfTracks(Noisy(1.0, 1.0, 0.3))->value, 1.0, 0.1);
}

TEST(NoiseCheck, NoiseOfSensorsIsMeasuredAtAnyRate) {
  for (const double rate : {100.0, 200.0, 500.0}) {
    for (const double times : {1.0, 10.0}) {
      const Recording recording = Noisy(1.0, times, 0.0, rate);
      const auto gyroscope = NoiseOfSensor(recording.imu, &ImuMeasurement::gyroscope);
      const auto accelerometer = NoiseOfSensor(recording.imu, &ImuMeasurement::acceleration);
      ASSERT_TRUE(gyroscope && accelerometer);
      EXPECT_NEAR(gyroscope->noise.value / times / recording.calibration.noise.gyroscope, 1.0, 0.05) << rate;
      EXPECT_NEAR(accelerometer->noise.value / times / recording.calibration.noise.accelerometer, 1.0, 0.05) << rate;
    }
  }
}

TEST(NoiseCheck, VibrationThatComesAndGoesIsNoNoise) {
  Recording recording = Noisy(1.0);
  Random random(1);
  for (ImuMeasurement& m : recording.imu)
    if (std::fmod(m.t, 4.0) > 2.0) m.acceleration += 0.5 * Vec3(random.Normal(), random.Normal(), random.Normal());
  EXPECT_FALSE(NoiseOfSensor(recording.imu, &ImuMeasurement::acceleration));
  OdometrySettings settings;
  EXPECT_EQ(Names(CheckNoise(&recording, &settings)), "");
}

// A motor at 70 Hz, or a rotor whose speed wanders; and the same noise below it as without.
TEST(NoiseCheck, VibrationThatLastsIsNamedAndNoNoise) {
  for (const double wander : {0.0, 0.3}) {
    Recording recording = Noisy(1.0);
    const double told = recording.calibration.noise.accelerometer;
    Random random(1);
    double phase = 0.0;
    for (ImuMeasurement& m : recording.imu) {
      phase += 2.0 * M_PI * 70.0 / 200.0 + wander * random.Normal();
      m.acceleration += 0.6 * std::sin(phase) * Vec3(1.0, -0.7, 0.5);
    }
    OdometrySettings settings;
    const RecordingWarnings warnings = CheckNoise(&recording, &settings);
    ASSERT_FALSE(warnings.empty());
    EXPECT_EQ(warnings[0].name, "accelerometer_vibration");
    EXPECT_GT(warnings[0].value, 5.0 * told);
    EXPECT_LT(recording.calibration.noise.accelerometer, 0.5 * warnings[0].value) << "a bound: motion is in it";
  }
}

TEST(NoiseCheck, AsMuchAsIsSaidOrLessChangesNothing) {
  for (const double pixels : {0.3, 1.0, 1.5}) {
    Recording recording = Noisy(pixels, 0.5);
    const ImuNoise noise = recording.calibration.noise;
    OdometrySettings settings;
    EXPECT_EQ(Names(CheckNoise(&recording, &settings)), "");
    EXPECT_EQ(settings.estimator.weights.pixel_sigma, WindowWeights().pixel_sigma);
    EXPECT_EQ(recording.calibration.noise.gyroscope, noise.gyroscope);
    EXPECT_EQ(recording.calibration.noise.accelerometer, noise.accelerometer);
  }
}

TEST(NoiseCheck, MoreThanIsSaidIsNamedAndUsed) {
  Recording recording = Noisy(2.5, 10.0);
  const ImuNoise noise = recording.calibration.noise;
  OdometrySettings settings;
  EXPECT_EQ(Names(CheckNoise(&recording, &settings)), "gyroscope_noise accelerometer_noise track_noise");
  EXPECT_NEAR(settings.estimator.weights.pixel_sigma, 2.5, 0.25);
  EXPECT_NEAR(settings.estimator.max_outlier_pixels, 2.0 * settings.estimator.weights.pixel_sigma, 1e-9);
  EXPECT_NEAR(recording.calibration.noise.gyroscope / noise.gyroscope, 10.0, 0.5);
  EXPECT_NEAR(recording.calibration.noise.accelerometer / noise.accelerometer, 10.0, 0.5);
  EXPECT_EQ(Names(CheckNoise(&recording, &settings)), "") << "said once";
}

TEST(NoiseCheck, WhatTheUserSaysIsUsed) {
  Recording recording = Noisy(2.5);
  OdometrySettings settings;
  settings.Set("pixel_sigma", "1");
  EXPECT_EQ(Names(CheckNoise(&recording, &settings)), "track_noise_set");
  EXPECT_EQ(settings.estimator.weights.pixel_sigma, 1.0);
  settings.Set("pixel_sigma", "2.5");
  EXPECT_EQ(Names(CheckNoise(&recording, &settings)), "");
  for (const char* wrong : {"0", "101", "x", "nan"})
    EXPECT_THROW(settings.Set("pixel_sigma", wrong), std::invalid_argument) << wrong;
}

}  // namespace
}  // namespace ch5
