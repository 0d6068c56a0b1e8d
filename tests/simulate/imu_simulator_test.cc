#include "ch5_backend/simulate/sensors/imu_simulator.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/sensors/paths.h"
#include "ch5_backend/types/inertial/preintegration.h"
#include "tests/simulate/course_arc.h"

namespace ch5 {
namespace {

ImuOptions Perfect() {
  ImuOptions options;
  options.noise_scale = 0.0;
  options.b_a = options.b_g = Vec3::Zero();
  return options;
}

// ‖error‖ of position, rotation and velocity at t1, predicted from the truth at t0 and a perfect IMU.
double PredictionError(const Trajectory& trajectory, double rate, double t0, double t1) {
  Calibration calibration;
  calibration.imu_rate = rate;
  const SimulatedImu run = SimulateImu(trajectory, calibration, Perfect());
  const Preintegration imu(SamplesBetween(run.measurements, t0, t1), Vec3::Zero(), Vec3::Zero(), calibration.noise);
  EXPECT_NEAR(imu.SumDt(), t1 - t0, 1e-12);
  const Motion i = trajectory.At(t0), j = trajectory.At(t1);
  const Vec3 g = calibration.GravityInWorld();
  const double dt = t1 - t0;
  const Vec3 p = i.T_W_B.p + i.v_W * dt + 0.5 * dt * dt * g + i.T_W_B.q * imu.Alpha();
  const Vec3 v = i.v_W + dt * g + i.T_W_B.q * imu.Beta();
  const Qd q = i.T_W_B.q * imu.Gamma();
  return (p - j.T_W_B.p).norm() + (v - j.v_W).norm() + LogSO3(q.conjugate() * j.T_W_B.q).norm();
}

TEST(ImuSimulator, PreintegrationReproducesTheTrajectoryToSecondOrder) {
  HandheldOptions options;
  options.duration = 3.0;
  for (const Trajectory& trajectory : {CourseArc(3.0), GaugePaperPath(GaugePath::kSine), Handheld(options)}) {
    // Both ends lie between samples: the interpolation is of second order too.
    const double at_200 = PredictionError(trajectory, 200.0, 0.5013, 1.5027);
    const double at_800 = PredictionError(trajectory, 800.0, 0.5013, 1.5027);
    EXPECT_LT(at_200, 5e-4);
    EXPECT_NEAR(at_200 / at_800, 16.0, 3.0);  // a quarter of the step, a sixteenth of the error
  }
}

// By hand: at rest, the accelerometer feels +9.81 upwards.
TEST(ImuSimulator, AtRestItFeelsTheReactionToGravityAndItsBiases) {
  HandheldOptions handheld;
  handheld.standstill_seconds = handheld.duration = 2.0;
  handheld.tilt_sigma = 0.0;
  ImuOptions options = Perfect();
  options.b_a = Vec3(0.1, -0.2, 0.3);
  options.b_g = Vec3(0.01, 0.02, -0.03);
  const SimulatedImu run = SimulateImu(Handheld(handheld), Calibration{}, options);
  ASSERT_EQ(run.measurements.size(), 401u);
  EXPECT_LT((run.measurements[77].acceleration - Vec3(0.1, -0.2, 10.11)).norm(), 1e-12);
  EXPECT_LT((run.measurements[77].gyroscope - options.b_g).norm(), 1e-12);
  EXPECT_EQ(run.measurements[77].t, RoundToNanosecond(77 / 200.0));
}

// 20,001 samples × 3 axes: the sampled deviation of a sample's noise is good to 1/√(2n) ≈ 0.3 % (one sigma), and so is
// that of the biases' steps.
TEST(ImuSimulator, NoiseHasTheDensitiesOfTheCalibration) {
  HandheldOptions handheld;
  handheld.duration = 100.0;
  const Trajectory trajectory = Handheld(handheld);
  const Calibration calibration;
  const SimulatedImu noisy = SimulateImu(trajectory, calibration, {}),
                     clean = SimulateImu(trajectory, calibration, Perfect());
  double acc = 0.0, gyr = 0.0, acc_walk = 0.0, gyr_walk = 0.0;
  const size_t n = noisy.measurements.size();
  for (size_t k = 0; k < n; ++k) {
    const StampedState& truth = noisy.truth[k];
    acc += (noisy.measurements[k].acceleration - clean.measurements[k].acceleration - truth.b_a).squaredNorm();
    gyr += (noisy.measurements[k].gyroscope - clean.measurements[k].gyroscope - truth.b_g).squaredNorm();
    if (k == 0) continue;
    acc_walk += (truth.b_a - noisy.truth[k - 1].b_a).squaredNorm();
    gyr_walk += (truth.b_g - noisy.truth[k - 1].b_g).squaredNorm();
  }
  const double samples = 3.0 * static_cast<double>(n), rate = calibration.imu_rate;
  EXPECT_NEAR(std::sqrt(acc / samples / rate) / calibration.noise.accelerometer, 1.0, 0.015);
  EXPECT_NEAR(std::sqrt(gyr / samples / rate) / calibration.noise.gyroscope, 1.0, 0.015);
  EXPECT_NEAR(std::sqrt(acc_walk / samples * rate) / calibration.noise.accelerometer_walk, 1.0, 0.015);
  EXPECT_NEAR(std::sqrt(gyr_walk / samples * rate) / calibration.noise.gyroscope_walk, 1.0, 0.015);
}

TEST(ImuSimulator, RefusesARateOrANoiseThatMakesNoSense) {
  Calibration calibration;
  calibration.imu_rate = 0.0;
  EXPECT_THROW(SimulateImu(CourseArc(1.0), calibration, {}), std::invalid_argument);
  calibration = {};
  calibration.noise.gyroscope = std::nan("");
  EXPECT_THROW(SimulateImu(CourseArc(1.0), calibration, {}), std::invalid_argument);
  calibration = {};
  calibration.noise.continuous = false;
  EXPECT_THROW(SimulateImu(CourseArc(1.0), calibration, {}), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
