#include "ch5_backend/simulate/sensors/imu_simulator.h"

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

void Check(const Calibration& calibration, const ImuOptions& options) {
  const ImuNoise& noise = calibration.noise;
  CheckPositive("Calibration::imu_rate", calibration.imu_rate);
  if (!noise.continuous) throw OptionError("SimulateImu: the noise must be given as densities (ImuNoise::continuous)");
  CheckNotNegative("ImuNoise::accelerometer", noise.accelerometer);
  CheckNotNegative("ImuNoise::gyroscope", noise.gyroscope);
  CheckNotNegative("ImuNoise::accelerometer_walk", noise.accelerometer_walk);
  CheckNotNegative("ImuNoise::gyroscope_walk", noise.gyroscope_walk);
  CheckNotNegative("ImuOptions::noise_scale", options.noise_scale);
}

}  // namespace

SimulatedImu SimulateImu(const Trajectory& trajectory, const Calibration& calibration, const ImuOptions& options) {
  Check(calibration, options);
  const ImuNoise& noise = calibration.noise;
  const double sqrt_rate = std::sqrt(calibration.imu_rate), scale = options.noise_scale;
  Random random(options.seed);
  Vec3 b_a = options.b_a, b_g = options.b_g;
  SimulatedImu run;
  const auto count = static_cast<int64_t>(std::floor(trajectory.Duration() * calibration.imu_rate + 1e-9));
  for (int64_t k = 0; k <= count; ++k) {
    const double t = RoundToNanosecond(static_cast<double>(k) / calibration.imu_rate);
    const Motion m = trajectory.At(t);
    const Vec3 f_B = m.T_W_B.q.conjugate() * (m.a_W - calibration.GravityInWorld());
    const Vec3 n_a = NormalVector(&random, scale * noise.accelerometer * sqrt_rate);
    const Vec3 n_g = NormalVector(&random, scale * noise.gyroscope * sqrt_rate);
    run.measurements.push_back({t, f_B + b_a + n_a, m.omega_B + b_g + n_g});
    run.truth.push_back({t, m.T_W_B, m.v_W, b_a, b_g});
    b_a += NormalVector(&random, scale * noise.accelerometer_walk / sqrt_rate);
    b_g += NormalVector(&random, scale * noise.gyroscope_walk / sqrt_rate);
  }
  return run;
}

}  // namespace ch5
