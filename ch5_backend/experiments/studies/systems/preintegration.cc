// Is a preintegration as certain as it may be?  Forster et al., T-RO 2017; Crassidis 2006 for densities
#include <cmath>

#include "ch5_backend/experiments/studies/systems/system_studies.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/inertial/preintegration.h"
#include "ch5_backend/types/recording.h"

namespace ch5 {
namespace {

constexpr int kDraws = 1000;
constexpr double kTunedRate = 200.0;  // at which VINS-Mono's σ of a sample is that of the density

// A lively piece of motion.
std::vector<ImuSample> Samples(double rate, double seconds) {
  std::vector<ImuSample> samples;
  const int n = static_cast<int>(std::lround(rate * seconds));
  for (int k = 0; k <= n; ++k) {
    const double t = k / rate;
    samples.push_back({k == 0 ? 0.0 : 1.0 / rate,
                       {1.0 + std::sin(7 * t), -2.0 + std::cos(5 * t), 9.81 + std::sin(3 * t)},
                       {0.6 * std::cos(4 * t), 0.5 + 0.4 * std::sin(6 * t), -0.7}});
  }
  return samples;
}

Preintegration Integrate(const std::vector<ImuSample>& samples, const ImuNoise& noise) {
  return {samples, Vec3::Zero(), Vec3::Zero(), noise};
}

// The same measurements with one draw of noise a sample, which two midpoint steps share, and biases that walk.
std::vector<ImuSample> Disturbed(std::vector<ImuSample> samples, const ImuNoise& density, Random* random) {
  const double dt = samples[1].dt;
  Vec3 b_a = Vec3::Zero(), b_g = Vec3::Zero();
  for (ImuSample& sample : samples) {
    sample.acceleration += b_a + NormalVector(random, density.accelerometer / std::sqrt(dt));
    sample.gyroscope += b_g + NormalVector(random, density.gyroscope / std::sqrt(dt));
    b_a += NormalVector(random, density.accelerometer_walk * std::sqrt(dt));
    b_g += NormalVector(random, density.gyroscope_walk * std::sqrt(dt));
  }
  return samples;
}

// VINS-Mono's reading of the same IMU, right at one rate.
ImuNoise PerSample(const ImuNoise& density) {
  const double root = std::sqrt(kTunedRate);
  return {density.accelerometer * root, density.gyroscope * root, density.accelerometer_walk * root,
          density.gyroscope_walk * root, false};
}

// Root mean square over the three axes.
double Sigma(const Mat1515& P, int row) { return std::sqrt(P.block<3, 3>(row, row).trace() / 3.0); }

void Append(double rate, double seconds, uint64_t seed, CsvTable* table) {
  const ImuNoise density = Calibration().noise;
  const std::vector<ImuSample> samples = Samples(rate, seconds);
  const Preintegration truth = Integrate(samples, density);
  const Preintegration per_sample = Integrate(samples, PerSample(density));
  Random random(seed);
  Mat1515 S = Mat1515::Zero();
  for (int k = 0; k < kDraws; ++k) {
    const Preintegration imu = Integrate(Disturbed(samples, density, &random), density);
    Vec15 e = Vec15::Zero();
    e.head<9>() << imu.Alpha() - truth.Alpha(), LogSO3(truth.Gamma().conjugate() * imu.Gamma()),
        imu.Beta() - truth.Beta();
    S += e * e.transpose() / kDraws;
  }
  const char* names[] = {"position", "rotation", "velocity"};
  for (int q = 0; q < 3; ++q) {
    table->Row(rate, seconds, names[q], Sigma(S, 3 * q), Sigma(truth.Covariance(), 3 * q),
               Sigma(per_sample.Covariance(), 3 * q));
  }
}

}  // namespace

CsvTable PreintegrationTable(int trial, const std::filesystem::path&) {
  CsvTable table("rate_hz,seconds,quantity,measured,claimed,claimed_per_sample");
  const auto seed = static_cast<uint64_t>(4 + trial);
  for (const double seconds : {0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0}) Append(kTunedRate, seconds, seed, &table);
  for (const double rate : {50.0, 100.0, 400.0, 800.0, 1600.0}) Append(rate, 0.5, seed, &table);
  return table;
}

}  // namespace ch5
