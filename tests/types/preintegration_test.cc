#include "ch5_backend/types/inertial/preintegration.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

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
  return {samples, b_a, b_g, noise};
}

// gtsam testImuFactor: 1 m/s² for 1 s gives half a meter and one meter a second.
TEST(Preintegration, ConstantAccelerationIsIntegratedExactly) {
  Preintegration imu({0.0, Vec3(1, 0, 0), Vec3::Zero()}, Vec3::Zero(), Vec3::Zero(), {});
  for (int k = 0; k < 10; ++k) imu.Add({0.1, Vec3(1, 0, 0), Vec3::Zero()});
  EXPECT_NEAR(imu.SumDt(), 1.0, 1e-14);
  EXPECT_LT((imu.Alpha() - Vec3(0.5, 0, 0)).norm(), 1e-14);
  EXPECT_LT((imu.Beta() - Vec3(1, 0, 0)).norm(), 1e-14);
  EXPECT_EQ(imu.Gamma().vec().norm(), 0.0);
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

  ImuNoise large;  // of a piece that lies in a gap
  large.accelerometer = large.gyroscope = 1.0;
  imu = Integrate(head, Vec3::Zero(), Vec3::Zero());
  imu.Append(Preintegration(tail, Vec3::Zero(), Vec3::Zero(), large));
  EXPECT_EQ(imu.Covariance(), Preintegration(samples, Vec3::Zero(), Vec3::Zero(), large).Covariance());
}

// The double integral of a turning force has a closed form:  β = T Γ₁ f,  α = T² Γ₂ f  with θ = ωT and
//   Γ₁ = I + (1 − cos θ)/θ² [θ] + (θ − sin θ)/θ³ [θ]²,   Γ₂ = ½I + (θ − sin θ)/θ³ [θ] + (θ² + 2 cos θ − 2)/(2θ⁴) [θ]².
// The midpoint rule comes to it with the square of its step.
TEST(Preintegration, ConstantForceAtAConstantRateAgreesWithItsClosedForm) {
  const double T = 1.5;
  const Vec3 omega(0.7, -1.1, 0.9), f(1.0, -2.0, 9.81);
  const Vec3 theta = T * omega;
  const double a = theta.norm();
  const Mat33 A = Hat(theta), I = Mat33::Identity();
  const Vec3 beta = T * ((I + (1 - std::cos(a)) / (a * a) * A + (a - std::sin(a)) / (a * a * a) * A * A) * f);
  const Vec3 alpha =
      T * T *
      ((0.5 * I + (a - std::sin(a)) / (a * a * a) * A + (a * a + 2 * std::cos(a) - 2) / (2 * a * a * a * a) * A * A) *
       f);
  std::vector<Vec3> errors;  // of position, velocity and rotation
  for (const int steps : {100, 200}) {
    Preintegration imu({0.0, f, omega}, Vec3::Zero(), Vec3::Zero(), {});
    for (int k = 0; k < steps; ++k) imu.Add({T / steps, f, omega});
    errors.emplace_back((imu.Alpha() - alpha).norm(), (imu.Beta() - beta).norm(),
                        LogSO3(ExpSO3(-theta) * imu.Gamma()).norm());
  }
  EXPECT_LT(errors[1].maxCoeff(), 2e-4);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(errors[0][k] / errors[1][k], 4.0, 0.05) << k;
}

// Without a turn, n steps of dt with the force a, T = n dt: the biases' Jacobians are sums that can be done by hand.
//   ∂β/∂b_a = −T I,  ∂α/∂b_a = −½T² I,  ∂γ/∂b_g = −T I,  ∂β/∂b_g = ½T² [a],  ∂α/∂b_g = (T³/6 + T dt²/12) [a]
TEST(Preintegration, BiasJacobianByHand) {
  const Vec3 a(1, 2, 9.81);
  for (const int n : {1, 8}) {
    const double dt = 0.05, T = n * dt;
    Preintegration imu({0.0, a, Vec3::Zero()}, Vec3::Zero(), Vec3::Zero(), {});
    for (int k = 0; k < n; ++k) imu.Add({dt, a, Vec3::Zero()});
    Eigen::Matrix<double, 9, 6> expected = Eigen::Matrix<double, 9, 6>::Zero();
    const Mat33 I = Mat33::Identity();
    expected.block<3, 3>(0, 0) = -0.5 * T * T * I;
    expected.block<3, 3>(6, 0) = -T * I;
    expected.block<3, 3>(3, 3) = -T * I;
    expected.block<3, 3>(6, 3) = 0.5 * T * T * Hat(a);
    expected.block<3, 3>(0, 3) = (T * T * T / 6 + T * dt * dt / 12) * Hat(a);
    EXPECT_LT((imu.BiasJacobian() - expected).norm(), 1e-14) << n;
  }
}

// One step of an IMU at rest without gravity, by hand: of two samples the mean counts, so var(a) = σ_a²/2; var(v) = dt²/2 σ_a²,
// var(p) = dt⁴/8 σ_a², cov(p, v) = dt³/4 σ_a², var(θ) = dt²/2 σ_g², and a bias walks by dt σ_w.
TEST(Preintegration, CovarianceOfAStepByHand) {
  const double dt = 0.1;
  const ImuNoise noise{0.2, 0.03, 0.04, 0.005, false};
  Preintegration imu(ImuSample(), Vec3::Zero(), Vec3::Zero(), noise);
  imu.Add({dt, Vec3::Zero(), Vec3::Zero()});
  Mat1515 expected = Mat1515::Zero();
  const Mat33 I = Mat33::Identity();
  expected.block<3, 3>(0, 0) = std::pow(dt, 4) / 8 * 0.04 * I;
  expected.block<3, 3>(0, 6) = expected.block<3, 3>(6, 0) = std::pow(dt, 3) / 4 * 0.04 * I;
  expected.block<3, 3>(6, 6) = dt * dt / 2 * 0.04 * I;
  expected.block<3, 3>(3, 3) = dt * dt / 2 * 0.0009 * I;
  expected.block<3, 3>(9, 9) = dt * dt * 0.0016 * I;
  expected.block<3, 3>(12, 12) = dt * dt * 0.000025 * I;
  EXPECT_LT((imu.Covariance() - expected).norm(), 1e-17);
}

// All fifteen: biases that walk, and through the turns and forces take position, rotation and velocity with them. basalt
// asks that the two Gaussians be at most 0.08 nats apart; 4,000 samples of the right one are 15·16/(4·4000) = 0.015 apart.
TEST(Preintegration, CovarianceAgreesWithMonteCarlo) {
  const ImuNoise noise{0.08, 0.004, 2.0, 0.2, false};  // walks that count for as much as the noise
  const std::vector<ImuSample> samples = Samples();
  const Preintegration truth = Integrate(samples, Vec3::Zero(), Vec3::Zero(), noise);
  Random random(4);
  constexpr int kRuns = 4000;
  Mat1515 sum = Mat1515::Zero();
  for (int run = 0; run < kRuns; ++run) {
    // The model takes the two samples of a step for independent: noise is drawn anew for each end of each step.
    Vec3 p = Vec3::Zero(), v = Vec3::Zero(), b_a = Vec3::Zero(), b_g = Vec3::Zero();
    Qd q = Qd::Identity();
    for (size_t k = 1; k < samples.size(); ++k) {
      ImuSample s0 = samples[k - 1], s1 = samples[k];
      for (ImuSample* sample : {&s0, &s1}) {
        sample->acceleration += NormalVector(&random, noise.accelerometer);
        sample->gyroscope += NormalVector(&random, noise.gyroscope);
      }
      Preintegration step(s0, b_a, b_g, noise);
      step.Add(s1);
      p += v * s1.dt + q * step.Alpha();
      v += q * step.Beta();
      q = (q * step.Gamma()).normalized();
      b_a += NormalVector(&random, noise.accelerometer_walk * s1.dt);
      b_g += NormalVector(&random, noise.gyroscope_walk * s1.dt);
    }
    Vec15 error;
    error << p - truth.Alpha(), LogSO3(truth.Gamma().conjugate() * q), v - truth.Beta(), b_a, b_g;
    sum += error * error.transpose() / kRuns;
  }
  for (int i = 0; i < 15; ++i) {
    EXPECT_NEAR(sum(i, i) / truth.Covariance()(i, i), 1.0, 0.1) << i;  // 1/√2000 = 2.2 % (one sigma)
  }
  // KL = ½ (tr(P⁻¹S) − 15 − ln|P⁻¹S|), over unknowns scaled to a unit diagonal.
  const Vec15 scale = truth.Covariance().diagonal().cwiseSqrt().cwiseInverse();
  const Mat1515 P = scale.asDiagonal() * truth.Covariance() * scale.asDiagonal();
  const Mat1515 ratio = P.inverse() * (scale.asDiagonal() * sum * scale.asDiagonal());
  EXPECT_LT(0.5 * (ratio.trace() - 15 - std::log(ratio.determinant())), 0.03);
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
  Preintegration imu(ImuSample(), Vec3::Zero(), Vec3::Zero(), {});
  EXPECT_THROW(imu.Add({0.0, Vec3::Zero(), Vec3::Zero()}), std::invalid_argument);
  EXPECT_THROW(imu.Add({-0.1, Vec3::Zero(), Vec3::Zero()}), std::invalid_argument);
  EXPECT_THROW(imu.Add({0.1, Vec3(NAN, 0, 0), Vec3::Zero()}), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
