#pragma once
/// An IMU on an analytic trajectory:
///
///   f_B = R_W_Bᵀ (a_W − g_W) + b_a + n_a,   ω = ω_B + b_g + n_g,   g_W = (0, 0, −9.81)
///
/// A white noise of density σ_c [unit/√Hz] has per sample the deviation σ_c √rate; a bias whose drift has the density
/// σ_w moves by σ_w √dt from sample to sample.  Source: Crassidis, "Sigma-Point Kalman Filtering for Integrated GPS
/// and Inertial Navigation", 2006, appendix.

#include "ch5_backend/simulate/sensors/trajectory.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {

struct ImuOptions {
  double noise_scale = 1.0;  ///< times the calibration's densities; 0 gives a perfect IMU with constant biases
  Vec3 b_a = Vec3(0.05, -0.03, 0.02);    ///< accelerometer bias at time 0 [m/s²]
  Vec3 b_g = Vec3(-0.002, 0.02, 0.008);  ///< gyroscope bias at time 0 [rad/s]
  uint64_t seed = 1;
};

/// What the IMU reads along a trajectory.
struct SimulatedImu {
  std::vector<ImuMeasurement> measurements;  ///< at imu_rate, from time 0 to the trajectory's end
  std::vector<StampedState> truth;           ///< at the same times, with the true biases
};

/// @param calibration  the IMU's rate, its noise densities, gravity
/// @throws OptionError if the rate is not positive, or the noise not a finite density (noise.continuous)
SimulatedImu SimulateImu(const Trajectory& trajectory, const Calibration& calibration, const ImuOptions& options);

}  // namespace ch5
