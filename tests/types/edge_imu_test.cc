#include "ch5_backend/types/inertial/edge_imu.h"

#include <gtest/gtest.h>

#include "ch5_backend/evaluate/nees.h"
#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/simulate/sensors/imu_simulator.h"
#include "ch5_backend/simulate/sensors/paths.h"
#include "tests/derivatives.h"

namespace ch5 {
namespace {

std::shared_ptr<Preintegration> SomeImu(double turn) {
  auto imu = std::make_shared<Preintegration>(ImuSample{0.0, Vec3(0.5, 0.2, 9.7), Vec3(0.1, turn, -0.2)},
                                              Vec3(0.05, 0.02, -0.01), Vec3(0.01, -0.02, 0.005), ImuNoise{});
  for (int k = 1; k <= 20; ++k) {
    imu->Add({0.005, Vec3(0.5 + 0.02 * k, 0.2, 9.7 - 0.01 * k), Vec3(0.1, turn + 0.01 * k, -0.2)});
  }
  return imu;
}

TEST(EdgeImu, JacobiansAgreeWithCentralDifferences) {
  Random random(11);
  for (const double scale : {0.0, 1e-9, 1e-3, 0.3, 1.5}) {  // identity, tiny, small, ordinary, large residual
    for (const double turn : {0.0, 1.0}) {
      const auto pose = [&] {
        return std::make_shared<VertexPose>(ExpSO3(NormalVector(&random, scale)), NormalVector(&random, scale));
      };
      const auto speed_bias = [&] {
        Vec9 x;
        x << NormalVector(&random, scale), 0.1 * NormalVector(&random, scale), 0.02 * NormalVector(&random, scale);
        return std::make_shared<VertexSpeedBias>(x);
      };
      auto pose_i = pose(), pose_j = pose();
      auto sb_i = speed_bias(), sb_j = speed_bias();
      EdgeImu edge(pose_i, sb_i, pose_j, sb_j, SomeImu(turn));
      ExpectJacobiansAreDerivatives(&edge);
    }
  }
}

// x, y, z and yaw cannot be seen by an IMU (basalt's test_vio: ≤ 1e-8, yaw ≤ 1e-6): moving both frames leaves r alone.
TEST(EdgeImu, ResidualIsInvariantUnderTranslationAndYaw) {
  auto pose_i = std::make_shared<VertexPose>(ExpSO3({0.1, 0.2, 0.3}), Vec3(1, 2, 3));
  auto pose_j = std::make_shared<VertexPose>(ExpSO3({0.2, 0.1, 0.5}), Vec3(1.1, 2.2, 3));
  Vec9 v_i, v_j;
  v_i << 1, 2, 0.5, 0.05, 0, 0, 0, 0.01, 0;
  v_j << 1.1, 2.1, 0.4, 0.05, 0, 0, 0, 0.01, 0;
  auto sb_i = std::make_shared<VertexSpeedBias>(v_i), sb_j = std::make_shared<VertexSpeedBias>(v_j);
  EdgeImu edge(pose_i, sb_i, pose_j, sb_j, SomeImu(0.4));
  edge.ComputeResidual();
  const VecX before = edge.Residual();
  const Qd yaw = ExpSO3({0, 0, 0.7});
  for (auto& pose : {pose_i, pose_j}) pose->SetPose(yaw * pose->q(), yaw * pose->p() + Vec3(3, -4, 5));
  for (auto& sb : {sb_i, sb_j}) {
    Vec9 x = sb->GetEstimate();
    x.head<3>() = yaw * Vec3(x.head<3>());
    sb->SetEstimate(x);
  }
  edge.ComputeResidual();
  EXPECT_LT((edge.Residual() - before).norm(), 1e-12);
}

TEST(EdgeImu, InformationIsTheInverseOfTheCovariance) {
  const auto imu = SomeImu(0.4);
  auto pose_i = std::make_shared<VertexPose>(), pose_j = std::make_shared<VertexPose>();
  auto sb_i = std::make_shared<VertexSpeedBias>(), sb_j = std::make_shared<VertexSpeedBias>();
  EdgeImu edge(pose_i, sb_i, pose_j, sb_j, imu);
  const MatXX product = edge.Information() * imu->Covariance();
  EXPECT_LT((product - MatXX::Identity(15, 15)).cwiseAbs().maxCoeff(), 1e-8);
  const auto empty = std::make_shared<Preintegration>(ImuSample{}, Vec3::Zero(), Vec3::Zero(), ImuNoise{});
  EXPECT_THROW(EdgeImu(pose_i, sb_i, pose_j, sb_j, empty), std::invalid_argument);
}

// The states that a trajectory has at two times, and the edge between them from what an IMU measures there.
struct Flight {
  explicit Flight(const Vec3& b_a, const Vec3& b_g, double noise_scale = 0.0, double duration = 2.0) {
    ImuOptions options;
    options.noise_scale = noise_scale;
    options.b_a = b_a;
    options.b_g = b_g;
    HandheldOptions handheld;
    handheld.duration = duration;
    run = SimulateImu(Handheld(handheld), calibration, options);
  }
  std::shared_ptr<VertexPose> Pose(size_t k) const {
    return std::make_shared<VertexPose>(run.truth[k].T_W_B.q, run.truth[k].T_W_B.p);
  }
  std::shared_ptr<VertexSpeedBias> SpeedBias(size_t k) const {
    Vec9 x;
    x << run.truth[k].v_W, run.truth[k].b_a, run.truth[k].b_g;
    return std::make_shared<VertexSpeedBias>(x);
  }
  /// From measurement i to measurement j, integrated at the given biases.
  EdgeImu Between(size_t i, size_t j, const Vec3& b_a, const Vec3& b_g) const {
    const auto sample = [this](size_t k, double dt) {
      return ImuSample{dt, run.measurements[k].acceleration, run.measurements[k].gyroscope};
    };
    auto imu = std::make_shared<Preintegration>(sample(i, 0.0), b_a, b_g, calibration.noise);
    for (size_t k = i + 1; k <= j; ++k) imu->Add(sample(k, run.measurements[k].t - run.measurements[k - 1].t));
    return EdgeImu(Pose(i), SpeedBias(i), Pose(j), SpeedBias(j), imu, -calibration.GravityInWorld());
  }
  Calibration calibration;
  SimulatedImu run;
};

// okvis TestImuError: the truth has no residual but what the integration's step leaves.
TEST(EdgeImu, TruthOfATrajectoryHasNoResidual) {
  const Vec3 b_a(0.05, -0.03, 0.02), b_g(-0.002, 0.02, 0.008);
  const Flight flight(b_a, b_g);
  for (const size_t start : {0u, 100u, 250u}) {
    EdgeImu edge = flight.Between(start, start + 100, b_a, b_g);
    edge.ComputeResidual();
    EXPECT_LT(edge.Residual().norm(), 5e-4) << start;
    EXPECT_LT(edge.Chi2(), 0.1) << start;  // far below the noise of 15 expected
  }
}

// Integrated at other biases than the states': the correction is of first order, so half the error leaves a quarter.
TEST(EdgeImu, BiasCorrectionIsGoodToSecondOrder) {
  const Vec3 b_a(0.05, -0.03, 0.02), b_g(-0.002, 0.02, 0.008), off_a(0.4, -0.3, 0.2), off_g(0.08, -0.06, 0.1);
  const Flight flight(b_a, b_g);
  EdgeImu exact = flight.Between(100, 200, b_a, b_g);
  exact.ComputeResidual();
  double before = 0.0;
  for (const double size : {1.0, 0.5, 0.25}) {
    EdgeImu edge = flight.Between(100, 200, b_a + size * off_a, b_g + size * off_g);
    edge.ComputeResidual();
    const double error = (edge.Residual() - exact.Residual()).norm();
    if (before > 0.0) {
      EXPECT_NEAR(before / error, 4.0, 0.5) << size;
    }
    before = error;
  }
  EXPECT_LT(before, 1e-3);
  // Without the correction the error would be of the biases' own size.
  EXPECT_GT(0.25 * 0.5 * off_a.norm(), 50 * before);
}

// The covariance that is claimed is the one that errors have: over 200 pieces of 0.5 s, rᵀWr of the truth is 15 in the mean.
TEST(EdgeImu, ResidualOfTheTruthIsAsLargeAsItsCovarianceSays) {
  const Flight flight(Vec3(0.05, -0.03, 0.02), Vec3(-0.002, 0.02, 0.008), 1.0, 101.0);
  constexpr int kRuns = 200;
  double sum = 0.0;
  for (size_t k = 0; k < kRuns; ++k) {
    const StampedState& start = flight.run.truth[100 * k];
    EdgeImu edge = flight.Between(100 * k, 100 * k + 100, start.b_a, start.b_g);
    edge.ComputeResidual();
    sum += edge.Chi2();
  }
  const ConfidenceBand band = ChiSquaredBand(15, kRuns, 3.0);
  EXPECT_TRUE(band.Contains(sum / kRuns)) << sum / kRuns << " in [" << band.low << ", " << band.high << "]";
}

// By hand: for 0.5 s an IMU at rest feels (0, 0, 9.81); where G is taken for (0, 0, 9.8), v differs by 0.005, p by 0.00125.
TEST(EdgeImu, ReactionIsTheGravityThatItIsTold) {
  auto imu = std::make_shared<Preintegration>(ImuSample{0.0, Vec3(0, 0, 9.81), Vec3::Zero()}, Vec3::Zero(),
                                              Vec3::Zero(), ImuNoise{});
  for (int k = 0; k < 100; ++k) imu->Add({0.005, Vec3(0, 0, 9.81), Vec3::Zero()});
  const auto pose = [] { return std::make_shared<VertexPose>(); };
  const auto rest = [] { return std::make_shared<VertexSpeedBias>(); };
  EdgeImu edge(pose(), rest(), pose(), rest(), imu, Vec3(0, 0, 9.80));
  edge.ComputeResidual();
  Vec15 expected = Vec15::Zero();
  expected[2] = -0.00125;
  expected[8] = -0.005;
  EXPECT_LT((edge.Residual() - expected).norm(), 1e-12);
}

TEST(EdgePrior, JacobiansAgreeWithCentralDifferences) {
  Random random(5);
  for (const double scale : {0.0, 1e-6, 0.5}) {
    auto pose = std::make_shared<VertexPose>(ExpSO3(NormalVector(&random, 1.0)), NormalVector(&random, 1.0));
    auto sb = std::make_shared<VertexSpeedBias>(Vec9::Constant(0.1));
    Prior prior{{pose, sb}, {pose->Parameters(), sb->Parameters()}, MatXX::Random(7, 15), VecX::Random(7)};
    const VecX delta = scale * VecX::Random(6);
    pose->Plus(delta.data());
    EdgePrior edge(prior);
    ExpectJacobiansAreDerivatives(&edge);
  }
}

// q and −q are one rotation: the prior must not tell them apart (OK9).
TEST(EdgePrior, DoesNotSeeTheSignOfAQuaternion) {
  auto pose = std::make_shared<VertexPose>(ExpSO3({0.3, -0.2, 0.1}), Vec3(1, 2, 3));
  Vec7 x0;
  x0 << 0.9, 2.1, 3.0, ExpSO3({0.25, -0.2, 0.12}).coeffs();
  Vec7 negated = x0;
  negated.tail<4>() *= -1.0;
  const MatXX J = MatXX::Identity(6, 6);
  EdgePrior plain({{pose}, {x0}, J, VecX::Zero(6)}), other({{pose}, {negated}, J, VecX::Zero(6)});
  plain.ComputeResidual();
  other.ComputeResidual();
  EXPECT_EQ(plain.Residual(), other.Residual());
}

}  // namespace
}  // namespace ch5
