// The similarity that takes the gauge out, and the errors that are left.
#include <gtest/gtest.h>

#include <limits>

#include "ch5_backend/evaluate/reconstruction.h"
#include "ch5_backend/math/so3.h"
#include "ch5_backend/simulate/random.h"

namespace ch5 {
namespace {

std::vector<Vec3> Cloud(int count, uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.push_back(UniformVector(&random, Vec3(-3, -3, -3), Vec3(3, 3, 3)));
  return points;
}

std::vector<Vec3> Moved(const Similarity& S, const std::vector<Vec3>& points) {
  std::vector<Vec3> moved;
  for (const Vec3& x : points) moved.push_back(S * x);
  return moved;
}

const Similarity kKnown{2.5, ExpSO3({0.3, -1.1, 2.0}), {4.0, -5.0, 6.0}};

void ExpectSame(const Similarity& a, const Similarity& b, double tolerance) {
  EXPECT_NEAR(a.scale, b.scale, tolerance);
  EXPECT_LT(LogSO3(a.q.conjugate() * b.q).norm(), tolerance);
  EXPECT_LT((a.p - b.p).norm(), tolerance);
}

// Of a cloud, of three points, and of a plane.
TEST(AlignUmeyama, RecoversAKnownSimilarity) {
  for (const int count : {30, 3, 20}) {
    auto from = Cloud(count, 1);
    if (count < 30) {
      for (Vec3& x : from) x.z() = 0.0;
    }
    const auto found = AlignUmeyama(from, Moved(kKnown, from));
    ASSERT_TRUE(found);
    ExpectSame(*found, kKnown, 1e-11);  // rounding of coordinates of order 10
  }
}

TEST(AlignUmeyama, NeverAnswersWithAMirror) {
  const auto from = Cloud(30, 4);
  auto mirrored = from;
  for (Vec3& x : mirrored) x.x() = -x.x();
  const auto found = AlignUmeyama(from, mirrored);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->q.toRotationMatrix().determinant(), 1.0, 1e-12);
  EXPECT_GT(found->scale, 0.0);
}

// No similarity nearby does better, with noise that none can explain.
TEST(AlignUmeyama, IsTheLeastSquaresOptimum) {
  const auto from = Cloud(30, 5);
  auto to = Moved(kKnown, from);
  const auto noise = Cloud(30, 6);
  for (size_t i = 0; i < to.size(); ++i) to[i] += 0.1 * noise[i];
  const auto cost = [&](const Similarity& S) {
    double sum = 0.0;
    for (size_t i = 0; i < to.size(); ++i) sum += (to[i] - S * from[i]).squaredNorm();
    return sum;
  };
  const auto best = AlignUmeyama(from, to);
  ASSERT_TRUE(best);
  Random random(7);
  for (int trial = 0; trial < 200; ++trial) {
    Similarity other = *best;
    const Vec7 d = NormalVector<7>(&random, 1e-4);
    other.scale += d[0];
    other.p += d.segment<3>(1);
    other.q = other.q * ExpSO3(d.tail<3>());
    EXPECT_GT(cost(other), cost(*best));
  }
}

TEST(AlignUmeyama, RefusesWhatDoesNotDetermineARotation) {
  const auto two = Cloud(2, 8);
  EXPECT_FALSE(AlignUmeyama(two, two));
  const std::vector<Vec3> line = {{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {5, 10, 15}};
  EXPECT_FALSE(AlignUmeyama(line, line));
  const std::vector<Vec3> same(5, Vec3::Ones());
  EXPECT_FALSE(AlignUmeyama(same, same));
  auto bad = Cloud(5, 9);
  bad[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(AlignUmeyama(bad, bad));
  EXPECT_FALSE(AlignUmeyama(Cloud(5, 1), Cloud(4, 1)));
}

TEST(Reconstruction, ErrorsDoNotDependOnTheGaugeAfterAlignment) {
  MonoBaOptions options;
  options.position_sigma = 0.1;
  options.rotation_sigma = 0.03;
  const MonoBaScene scene = SimulateMonoBa(options);
  const Reconstruction truth = TruthOf(scene);
  Reconstruction estimate{scene.initial_frames, scene.points};
  estimate.points[3].x() += 0.5;
  const Rmse before = CompareAligned(estimate, truth).value();
  for (Transform& T : estimate.frames) T = kKnown * T;
  estimate.points = Moved(kKnown, estimate.points);
  const Rmse after = CompareAligned(estimate, truth).value();
  EXPECT_GT(before.position, 1e-3);
  EXPECT_NEAR(after.position, before.position, 1e-12);
  EXPECT_NEAR(after.rotation, before.rotation, 1e-12);
  EXPECT_NEAR(after.point, before.point, 1e-12);
}

// Cameras at the truth have no error, however wrong the points are.
TEST(Reconstruction, PointsHaveNoSayInTheAlignmentOfCameras) {
  const MonoBaScene scene = SimulateMonoBa(MonoBaOptions());
  const Reconstruction truth = TruthOf(scene);
  Reconstruction estimate = truth;
  for (Vec3& p : estimate.points) p += Vec3(0.5, 0.0, 0.1);
  const Rmse error = CompareAligned(estimate, truth).value();
  EXPECT_LT(error.position, 1e-12);
  EXPECT_LT(error.point, 1e-12) << "all points are shifted alike";
}

TEST(Reconstruction, TwoCamerasDetermineNoAlignment) {
  MonoBaOptions options;
  options.frames = 2;
  const Reconstruction truth = TruthOf(SimulateMonoBa(options));
  EXPECT_FALSE(CompareAligned(truth, truth));
}

TEST(Reconstruction, OfTheTrueStatesWithoutNoiseIsTheTruth) {
  MonoBaOptions options;
  options.pixel_sigma = 0.0;
  options.depth_sigma = 0.0;
  const MonoBaScene scene = SimulateMonoBa(options);
  MonoBa ba = BuildMonoBa(scene, Gauge::kFree, 1.0, 0.0);
  const Rmse error = Compare(EstimateOf(scene, ba), TruthOf(scene));
  EXPECT_LT(error.position, 1e-14);
  EXPECT_LT(error.point, 1e-13);
}

}  // namespace
}  // namespace ch5
