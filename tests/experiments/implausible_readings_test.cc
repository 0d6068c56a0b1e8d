#include "ch5_backend/experiments/studies/implausible_readings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <tuple>

#include "ch5_backend/experiments/studies/recording_warnings.h"
#include "ch5_backend/experiments/studies/turn_warnings.h"
#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "tests/experiments/warning_names.h"
#include "tests/temporary_folder.h"
#include "tests/window/simulations.h"

namespace ch5 {
namespace {

constexpr size_t kMiddle = 1000;  // of 2001 readings

Recording Healthy() { return SimulateRoom({10.0, /*standstill_seconds=*/1.0}); }

std::vector<int> LinesOf(const Recording& recording) {
  std::vector<int> lines(recording.imu.size());
  std::iota(lines.begin(), lines.end(), 2);
  return lines;
}

RecordingWarnings Check(Recording* recording) {
  return CheckReadings("imu.csv", LinesOf(*recording), /*strict=*/false, recording);
}

// Vibration is none of this, nor a body that stands still, a turntable, or a sensor without noise.
TEST(ImplausibleReadings, RecordingsInOrderStayAsTheyAre) {
  RoomOptions silent;
  silent.duration = 10.0;
  silent.simulation.imu.noise_scale = 0.0;
  for (const Recording& given : {Healthy(), SimulateCircle(10.0), SimulateRoom(silent)}) {
    Recording recording = given;
    EXPECT_EQ(Names(Check(&recording)), "");
    ASSERT_EQ(recording.imu.size(), given.imu.size());
    for (size_t k = 0; k < given.imu.size(); ++k) {
      EXPECT_EQ(recording.imu[k].acceleration, given.imu[k].acceleration);
      EXPECT_EQ(recording.imu[k].gyroscope, given.imu[k].gyroscope);
    }
  }
}

// Readings rounded to two decimals repeat at rest and share the peaks of their motion.
TEST(ImplausibleReadings, CoarseOnesAreNone) {
  Recording recording = Healthy();
  for (ImuMeasurement& m : recording.imu) {
    m.gyroscope = (m.gyroscope * 100.0).array().round() / 100.0;
    m.acceleration = (m.acceleration * 100.0).array().round() / 100.0;
  }
  EXPECT_EQ(Names(Check(&recording)), "");
}

TEST(ImplausibleReadings, ZerosRepeatsAndSpikesAreLeftOutAndNamed) {
  struct Case {
    std::string name;
    size_t count, line;
    void (*spoil)(std::vector<ImuMeasurement>*);
  };
  const Case cases[] = {
      {"imu_stuck", 20, kMiddle + 2,
       [](auto* imu) {
         for (size_t k = kMiddle; k < kMiddle + 20; ++k) (*imu)[k].gyroscope = (*imu)[k].acceleration = Vec3::Zero();
       }},
      {"imu_stuck", 1, kMiddle + 2, [](auto* imu) { (*imu)[kMiddle].acceleration.setZero(); }},
      {"imu_stuck", 40, 2,
       [](auto* imu) {
         for (size_t k = 0; k < 40; ++k) (*imu)[k].gyroscope = (*imu)[k].acceleration = Vec3::Zero();
       }},
      {"imu_stuck", 99, kMiddle + 3,
       [](auto* imu) {
         for (size_t k = kMiddle; k < kMiddle + 100; ++k) {
           (*imu)[k].gyroscope = (*imu)[kMiddle].gyroscope;
           (*imu)[k].acceleration = (*imu)[kMiddle].acceleration;
         }
       }},
      {"imu_stuck", 49, kMiddle + 3,
       [](auto* imu) {
         for (size_t k = kMiddle; k < kMiddle + 50; ++k) (*imu)[k].gyroscope = (*imu)[kMiddle].gyroscope;
       }},
      {"imu_spike", 1, kMiddle + 2, [](auto* imu) { (*imu)[kMiddle].acceleration.x() += 60.0; }},
      {"imu_spike", 2, kMiddle + 2,
       [](auto* imu) {
         for (const size_t k : {kMiddle, kMiddle + 1}) (*imu)[k].acceleration.y() -= 30.0;
       }},
      {"imu_spike", 3, kMiddle - 498,
       [](auto* imu) {
         for (const size_t k : {kMiddle - 500, kMiddle, kMiddle + 500}) (*imu)[k].gyroscope.y() -= 5.0;
       }},
  };
  for (const auto& [name, count, line, spoil] : cases) {
    Recording recording = Healthy();
    const size_t all = recording.imu.size();
    spoil(&recording.imu);
    Recording again = recording;
    const RecordingWarnings warnings = Check(&recording);
    ASSERT_EQ(Names(warnings), name);
    EXPECT_EQ(warnings[0].value, static_cast<double>(count));
    EXPECT_EQ(recording.imu.size(), all - count);
    const std::string place = "imu.csv:" + std::to_string(line) + ": at ";
    EXPECT_EQ(warnings[0].detail.rfind(place, 0), 0u) << warnings[0].detail;
    const std::string refused =
        test::Refusal<FileError>([&] { CheckReadings("imu.csv", LinesOf(again), /*strict=*/true, &again); });
    EXPECT_EQ(refused.rfind(place, 0), 0u) << refused;
  }
}

TEST(ImplausibleReadings, HeldValuesAreInterpolated) {
  for (const size_t held_for : {2u, 5u}) {
    const Recording whole = Healthy();
    Recording recording = whole;
    for (size_t k = 0; k < recording.imu.size(); ++k)
      recording.imu[k].acceleration = whole.imu[k / held_for * held_for].acceleration;
    const RecordingWarnings warnings = Check(&recording);
    ASSERT_EQ(Names(warnings), "accelerometer_held");
    EXPECT_NEAR(warnings[0].value, 200.0 / static_cast<double>(held_for), 0.2);
    const Vec3 &a = whole.imu[0].acceleration, &b = whole.imu[held_for].acceleration;
    EXPECT_TRUE(recording.imu[1].acceleration.isApprox(a + (b - a) / static_cast<double>(held_for), 1e-6));
    EXPECT_EQ(recording.imu[held_for].acceleration, b);
    EXPECT_EQ(recording.imu[7].gyroscope, whole.imu[7].gyroscope);
    EXPECT_NEAR(recording.calibration.noise.accelerometer / whole.calibration.noise.accelerometer,
                std::sqrt(static_cast<double>(held_for)), 5e-3);
  }
}

// 150 Hz in a log of 200: each time the newest reading there is.
TEST(ImplausibleReadings, ALogThatIsFilledUpIsNamed) {
  const Recording whole = Healthy();
  Recording recording = whole;
  for (size_t k = 0; k < recording.imu.size(); ++k) {
    recording.imu[k].gyroscope = whole.imu[k * 3 / 4].gyroscope;
    recording.imu[k].acceleration = whole.imu[k * 3 / 4].acceleration;
  }
  const RecordingWarnings warnings = Check(&recording);
  ASSERT_EQ(Names(warnings), "gyroscope_held accelerometer_held");
  EXPECT_NEAR(warnings[0].value, 150.0, 1.0);
  for (size_t k = 1; k + 1 < recording.imu.size(); ++k)
    EXPECT_NE(recording.imu[k].gyroscope, recording.imu[k - 1].gyroscope);
}

// Of a range that no sensor has it takes more, of a log that was smoothed both directions.
TEST(ImplausibleReadings, ALimitIsNamedBehindACalibrationAndASmoothingToo) {
  const Mat33 M = (Mat33() << 1.01, 0.003, -0.003, 0.003, 0.99, 0.003, -0.003, 0.003, 1.0).finished();
  RoomOptions silent;
  silent.duration = 10.0;
  silent.simulation.imu.noise_scale = 0.0;
  const Recording noisy = Healthy(), smooth = SimulateRoom(silent);
  for (const auto& [given, calibrated, most] :
       {std::tuple(&noisy, false, 1.9), {&noisy, true, 1.9}, {&noisy, false, 0.4}, {&smooth, false, 0.6}}) {
    Recording recording = *given;
    for (ImuMeasurement& m : recording.imu) {
      m.gyroscope = (5.0 * m.gyroscope).cwiseMax(-most).cwiseMin(most);
      if (calibrated) m.gyroscope = M * m.gyroscope + Vec3(0.01, -0.01, 0.02);
    }
    const RecordingWarnings warnings = Check(&recording);
    ASSERT_FALSE(warnings.empty()) << calibrated << " " << most;
    for (const RecordingWarning& warning : warnings) EXPECT_EQ(warning.name, "gyroscope_rail") << warning.words;
    EXPECT_EQ(recording.imu.size(), given->imu.size());
  }
}

TEST(ImplausibleReadings, AnAxisThatFeelsNothingIsNamedWhereTheBodyTurns) {
  for (const auto reading : {&ImuMeasurement::gyroscope, &ImuMeasurement::acceleration}) {
    for (const auto& [mean, noise] : {std::pair(0.0, 0.0), {0.01, 0.0}, {0.01, 0.05}}) {
      Recording recording = Healthy();
      Random random(1);
      for (ImuMeasurement& m : recording.imu) (m.*reading).y() = mean + noise * random.Normal();
      const RecordingWarnings warnings = Check(&recording);
      ASSERT_EQ(warnings.size(), 1u) << Names(warnings);
      EXPECT_NE(warnings[0].name.find("_dead"), std::string::npos);
      EXPECT_EQ(warnings[0].detail, "y");
    }
  }
}

TEST(ImplausibleReadings, ImagesThatTurnFartherThanTheGyroscopeTellWhy) {
  for (const double times : {0.88, 1.15}) {
    for (const std::string name : {"turns_focal", "turns_gyroscope"}) {
      Recording recording = Healthy();
      if (name == "turns_focal") {
        for (Image& image : recording.images)
          for (TrackedPoint& point : image.tracks) point.x *= times;
      } else {
        for (ImuMeasurement& m : recording.imu) m.gyroscope /= times;
      }
      OdometrySettings settings;
      RecordingWarnings warnings = CheckMeasurements(&settings, &recording);
      ASSERT_EQ(Names(warnings), name) << times;
      EXPECT_NEAR(warnings[0].value, times, 0.05);
      const double f = recording.calibration.fx, x = recording.images[0].tracks[0].x.x();
      const double turn = recording.imu[100].gyroscope.norm(), whole = Healthy().imu[100].gyroscope.norm();
      CorrectTurnGain(settings, &warnings, &recording);
      const bool is_focal = name == "turns_focal";
      EXPECT_EQ(Names(warnings), is_focal ? "focal_corrected" : "gyroscope_corrected");
      EXPECT_NEAR(recording.calibration.fx, is_focal ? times * f : f, 0.015 * f);
      EXPECT_NEAR(recording.imu[100].gyroscope.norm(), is_focal ? turn : whole, 0.015 * whole);
      EXPECT_NEAR(recording.images[0].tracks[0].x.x() * recording.calibration.fx, x * f, 1e-9) << "the same pixel";
    }
  }
  Recording recording = Healthy();
  for (ImuMeasurement& m : recording.imu) m.gyroscope *= 180.0 / M_PI;
  OdometrySettings settings;
  EXPECT_EQ(Names(CheckMeasurements(&settings, &recording)), "turns_unit");
}

// Outliers and a bias of the gyroscope look like turns.
TEST(ImplausibleReadings, OutliersMakeNoFocalLengthWrong) {
  RoomOptions options;
  options.simulation.camera.outlier_fraction = 0.03;
  options.simulation.camera.max_tracks = 60;
  options.simulation.imu.b_g = Vec3(-0.002, 0.02, 0.03);
  Recording recording = SimulateRoom(options);
  OdometrySettings settings;
  EXPECT_EQ(Names(CheckMeasurements(&settings, &recording)), "");
}

// Each of these turns the images otherwise than the gyroscope, in a way of its own.
TEST(ImplausibleReadings, WhatTurnsTheImagesOtherwiseIsNamedAndTakenAway) {
  const Recording healthy = SimulateRoom({});
  const double seconds = healthy.imu.back().t;
  const Calibration& c = healthy.calibration;
  const auto warning_of = [](Recording* recording, OdometrySettings* settings) {
    const RecordingWarnings warnings = CheckMeasurements(settings, recording);
    return warnings.size() == 1 ? warnings[0] : RecordingWarning{Names(warnings), 0.0, 0.0, ""};
  };
  {
    RoomOptions options;
    options.simulation.camera.pixel_sigma = 0.0;
    const Recording sharp = SimulateRoom(options);
    Recording recording = sharp;
    const double ms = 40.0, line = 1e-3 * ms * c.fy / c.height;  // a row is seen later by line · y
    for (size_t k = 1; k + 1 < sharp.images.size(); ++k) {
      const auto at = [&](size_t image, int id) -> const Vec2* {
        for (const TrackedPoint& point : sharp.images[image].tracks)
          if (point.id == id) return &point.x;
        return nullptr;
      };
      for (TrackedPoint& point : recording.images[k].tracks) {
        const Vec2 *before = at(k - 1, point.id), *after = at(k + 1, point.id);
        if (before && after)
          point.x += line * point.x.y() * (*after - *before) / (sharp.images[k + 1].t - sharp.images[k - 1].t);
      }
    }
    OdometrySettings settings;
    const RecordingWarning warning = warning_of(&recording, &settings);
    EXPECT_EQ(warning.name, "turns_shutter");
    EXPECT_NEAR(warning.value, ms, 0.15 * ms);
  }
  {
    Recording recording = healthy;
    const Vec3 drift(0.02, -0.01, 0.01);
    for (ImuMeasurement& m : recording.imu) m.gyroscope += m.t / seconds * drift;
    OdometrySettings settings;
    const RecordingWarning warning = warning_of(&recording, &settings);
    EXPECT_EQ(warning.name, "turns_drift");
    EXPECT_NEAR(warning.value, drift.norm(), 0.4 * drift.norm()) << "±18 % over eight seeds";
    EXPECT_GT(recording.calibration.noise.gyroscope_walk * std::sqrt(seconds), 0.8 * drift.norm());
  }
  {
    Recording recording = healthy;
    const double degrees = 4.0;
    recording.calibration.T_B_C.q =
        c.T_B_C.q * Qd(Eigen::AngleAxisd(degrees * M_PI / 180.0, Vec3(1, 2, 3).normalized()));
    OdometrySettings settings;
    const RecordingWarning warning = warning_of(&recording, &settings);
    EXPECT_EQ(warning.name, "turns_rotation");
    EXPECT_NEAR(warning.value, degrees, 0.15 * degrees);
    EXPECT_TRUE(settings.estimator.estimate_extrinsic);
  }
}

TEST(ImplausibleReadings, ARateThatIsNotTheCalibrationsIsNamed) {
  Recording recording = Healthy();
  for (size_t k = recording.imu.size() - 2; k > 0; --k)
    if (k % 4 == 3) recording.imu.erase(recording.imu.begin() + static_cast<std::ptrdiff_t>(k));
  OdometrySettings settings;
  const RecordingWarnings warnings = CheckMeasurements(&settings, &recording);
  ASSERT_EQ(Names(warnings), "imu_rate");
  EXPECT_NEAR(warnings[0].value, 150.0, 1.0);
}

TEST(ImplausibleReadings, AnAccelerometerThatFeelsAnotherGravityIsNamed) {
  for (const double times : {0.92, 1.08}) {
    Recording recording = Healthy();
    for (ImuMeasurement& m : recording.imu) m.acceleration *= times;
    const RecordingWarnings warnings = Check(&recording);
    ASSERT_EQ(Names(warnings), "gravity") << times;
    EXPECT_NEAR(warnings[0].value, 9.81 * times, 0.03 * 9.81 * times);
  }
}

// Which turns the gravity that it should feel, or hardly follows its motion.
TEST(ImplausibleReadings, NoAccelerometerIsBlamedForABiasedGyroscopeOrASlowImu) {
  for (const Vec3& bias : {Vec3(0.3, 0, 0), Vec3(0, 0.3, 0), Vec3(0, 0, 0.3), Vec3(-0.3, 0, 0), Vec3(0, -1.0, 0)}) {
    Recording recording = Healthy();
    for (ImuMeasurement& m : recording.imu) m.gyroscope += bias, m.acceleration *= 0.97;
    EXPECT_EQ(Names(Check(&recording)), "") << bias.transpose();
  }
  Recording recording = Healthy();
  std::vector<ImuMeasurement> slow;
  for (size_t k = 0; k < recording.imu.size(); k += 10) slow.push_back(recording.imu[k]);
  Random random(1);
  for (ImuMeasurement& m : slow) m.acceleration.y() = 0.5 * random.Normal();  // vibration between two readings
  recording.imu = slow;
  EXPECT_EQ(Names(Check(&recording)), "");
}

// The first seconds after a rest, and noise of 3 px, look like a delay or another focal length.
TEST(ImplausibleReadings, FewOrNoisyImagesTellNothing) {
  struct Case {
    uint64_t seed;
    double pixels, seconds;
  };
  for (const auto& [seed, pixels, seconds] :
       {Case{1, 0.5, 4.0}, Case{2, 0.5, 4.0}, Case{8, 0.5, 4.0}, Case{3, 3.0, 20.0}}) {
    RoomOptions options;
    options.seed = seed;
    options.simulation.imu.seed = seed;
    options.simulation.camera.seed = seed + 1;
    options.simulation.camera.pixel_sigma = pixels;
    Recording recording = SimulateRoom(options);
    while (recording.images.back().t > seconds) recording.images.pop_back();
    OdometrySettings settings;
    EXPECT_EQ(Names(CheckMeasurements(&settings, &recording)), "") << seed;
    EXPECT_EQ(settings.estimator.time_offset, 0.0) << seed;
  }
}

}  // namespace
}  // namespace ch5
