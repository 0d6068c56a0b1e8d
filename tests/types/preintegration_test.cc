#include "ch5_backend/types/preintegration.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

// A lively piece of motion: 40 samples at 200 Hz.
std::vector<ImuSample> Samples(double rate = 200.0, double seconds = 0.2) {
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

Preintegration Integrate(const std::vector<ImuSample>& samples, const Vec3& b_a, const Vec3& b_g,
                         const ImuNoise& noise = {}) {
  Preintegration imu(samples.front(), b_a, b_g, noise);
  for (size_t k = 1; k < samples.size(); ++k) imu.Add(samples[k]);
  return imu;
}

// gtsam testImuFactor: 1 m/s² for 1 s gives half a metre and one metre a second.
TEST(Preintegration, ConstantAccelerationIsIntegratedExactly) {
  Preintegration imu({0.0, Vec3(1, 0, 0), Vec3::Zero()}, Vec3::Zero(), Vec3::Zero(), {});
  for (int k = 0; k < 10; ++k) imu.Add({0.1, Vec3(1, 0, 0), Vec3::Zero()});
  EXPECT_NEAR(imu.SumDt(), 1.0, 1e-14);
  EXPECT_LT((imu.Alpha() - Vec3(0.5, 0, 0)).norm(), 1e-14);
  EXPECT_LT((imu.Beta() - Vec3(1, 0, 0)).norm(), 1e-14);
  EXPECT_EQ(imu.Gamma().vec().norm(), 0.0);
}

// A turn at a constant rate: the midpoint quaternion step is of second order, error ~ (ω dt)³/12 a step.
TEST(Preintegration, ConstantRateTurnsByItsAngle) {
  const Vec3 omega(0.3, -0.2, 0.5);
  Preintegration imu({0.0, Vec3::Zero(), omega}, Vec3::Zero(), Vec3::Zero(), {});
  for (int k = 0; k < 200; ++k) imu.Add({0.005, Vec3::Zero(), omega});
  EXPECT_LT((LogSO3(imu.Gamma()) - omega).norm(), 1e-6);
}

TEST(Preintegration, BiasJacobianPredictsReintegration) {
  const Vec3 b_a(0.1, -0.2, 0.05), b_g(0.02, 0.01, -0.03);
  const Preintegration imu = Integrate(Samples(), b_a, b_g);
  for (int k = 0; k < 6; ++k) {
    // Central differences; the rest is the second order in δ, and the first-order F of the step itself.
    const double step = 1e-4;
    Vec6 db = Vec6::Zero();
    db[k] = step;
    Preintegration plus = imu, minus = imu;
    plus.Reintegrate(b_a + db.head<3>(), b_g + db.tail<3>());
    minus.Reintegrate(b_a - db.head<3>(), b_g - db.tail<3>());
    const Eigen::Matrix<double, 9, 1> J = imu.BiasJacobian().col(k);
    EXPECT_LT(((plus.Alpha() - minus.Alpha()) / (2 * step) - J.head<3>()).norm(), 1e-3) << k;
    EXPECT_LT((LogSO3(minus.Gamma().conjugate() * plus.Gamma()) / (2 * step) - J.segment<3>(3)).norm(), 1e-3) << k;
    EXPECT_LT(((plus.Beta() - minus.Beta()) / (2 * step) - J.tail<3>()).norm(), 1e-3) << k;
  }
}

TEST(Preintegration, ReintegrationEqualsAFreshIntegration) {
  Preintegration imu = Integrate(Samples(), Vec3::Zero(), Vec3::Zero());
  const Vec3 b_a(0.3, 0.1, -0.2), b_g(-0.05, 0.04, 0.02);
  imu.Reintegrate(b_a, b_g);
  const Preintegration fresh = Integrate(Samples(), b_a, b_g);
  EXPECT_EQ(imu.Alpha(), fresh.Alpha());
  EXPECT_EQ(imu.Gamma().coeffs(), fresh.Gamma().coeffs());
  EXPECT_EQ(imu.Covariance(), fresh.Covariance());
}

TEST(Preintegration, TwoPiecesAppendedEqualTheWhole) {
  const std::vector<ImuSample> samples = Samples();
  const std::vector<ImuSample> head(samples.begin(), samples.begin() + 21), tail(samples.begin() + 20, samples.end());
  Preintegration imu = Integrate(head, Vec3::Zero(), Vec3::Zero());
  imu.Append(Integrate(tail, Vec3::Zero(), Vec3::Zero()));
  const Preintegration whole = Integrate(samples, Vec3::Zero(), Vec3::Zero());
  EXPECT_EQ(imu.Alpha(), whole.Alpha());
  EXPECT_EQ(imu.Covariance(), whole.Covariance());
  EXPECT_EQ(imu.SumDt(), whole.SumDt());
}

// The covariance against 3,000 noisy integrations: each entry's relative error is ~ 1/√3000 ≈ 2 % (one sigma).
TEST(Preintegration, CovarianceAgreesWithMonteCarlo) {
  ImuNoise noise;
  const std::vector<ImuSample> samples = Samples();
  const Preintegration truth = Integrate(samples, Vec3::Zero(), Vec3::Zero(), noise);
  Random random(3);
  constexpr int kRuns = 3000;
  Eigen::Matrix<double, 9, 9> sum = Eigen::Matrix<double, 9, 9>::Zero();
  for (int run = 0; run < kRuns; ++run) {
    // The model treats the two samples of a step as independent: noise is drawn anew for each end of each step.
    Vec3 p = Vec3::Zero(), v = Vec3::Zero();
    Qd q = Qd::Identity();
    for (size_t k = 1; k < samples.size(); ++k) {
      ImuSample s0 = samples[k - 1], s1 = samples[k];
      s0.acceleration += NormalVector(&random, noise.accelerometer);
      s0.gyroscope += NormalVector(&random, noise.gyroscope);
      s1.acceleration += NormalVector(&random, noise.accelerometer);
      s1.gyroscope += NormalVector(&random, noise.gyroscope);
      Preintegration step(s0, Vec3::Zero(), Vec3::Zero(), noise);
      step.Add(s1);
      p += v * s1.dt + q * step.Alpha();
      v += q * step.Beta();
      q = (q * step.Gamma()).normalized();
    }
    Eigen::Matrix<double, 9, 1> error;
    error << p - truth.Alpha(), LogSO3(truth.Gamma().conjugate() * q), v - truth.Beta();
    sum += error * error.transpose();
  }
  const Eigen::Matrix<double, 9, 9> sampled = sum / kRuns, P = truth.Covariance().topLeftCorner<9, 9>();
  for (int i = 0; i < 9; ++i) {
    EXPECT_NEAR(sampled(i, i) / P(i, i), 1.0, 0.12) << i;
    for (int j = 0; j < i; ++j) EXPECT_NEAR((sampled(i, j) - P(i, j)) / std::sqrt(P(i, i) * P(j, j)), 0.0, 0.08);
  }
}

TEST(Preintegration, ContinuousDensitiesDoNotDependOnTheRate) {
  ImuNoise noise;
  noise.continuous = true;
  const Preintegration slow = Integrate(Samples(200.0), Vec3::Zero(), Vec3::Zero(), noise);
  const Preintegration fast = Integrate(Samples(800.0), Vec3::Zero(), Vec3::Zero(), noise);
  for (int i = 0; i < 15; ++i) {
    EXPECT_NEAR(slow.Covariance()(i, i) / fast.Covariance()(i, i), 1.0, 0.02) << i;
  }
  noise.continuous = false;  // VINS' convention: four times the rate, about a quarter of the covariance
  const double ratio = Integrate(Samples(200.0), Vec3::Zero(), Vec3::Zero(), noise).Covariance()(6, 6) /
                       Integrate(Samples(800.0), Vec3::Zero(), Vec3::Zero(), noise).Covariance()(6, 6);
  EXPECT_NEAR(ratio, 4.0, 0.1);
}

TEST(Preintegration, RefusesTimeThatStandsStillAndNumbersThatAreNotFinite) {
  Preintegration imu({}, Vec3::Zero(), Vec3::Zero(), {});
  EXPECT_THROW(imu.Add({0.0, Vec3::Zero(), Vec3::Zero()}), std::invalid_argument);
  EXPECT_THROW(imu.Add({-0.1, Vec3::Zero(), Vec3::Zero()}), std::invalid_argument);
  EXPECT_THROW(imu.Add({0.1, Vec3(NAN, 0, 0), Vec3::Zero()}), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
