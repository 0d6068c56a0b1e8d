#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "ch5_backend/experiments/studies/odometry.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/track/track_images.h"
#include "tests/temporary_folder.h"
#include "tests/track/lenses.h"

namespace ch5 {
namespace {

TEST(Lens, BendsAsWorkedByHand) {
  Lens lens;
  lens.k << 0.1, 0.01, 0.001, 0.002;  // n = 5: 1 + 0.5 + 0.25 = 1.75; tangential (0.004 + 0.014, 0.013 + 0.008)
  EXPECT_LT((lens.Distort({1, 2}) - Vec2(1.75 + 0.018, 3.5 + 0.021)).norm(), 1e-12);
  lens.k3 = 0.002;  // 125 · 0.002 = 0.25 more
  EXPECT_LT((lens.Distort({1, 2}) - Vec2(2.0 + 0.018, 4.0 + 0.021)).norm(), 1e-12);
  lens.model = Lens::Model::kEquidistant;
  lens.k << 0.1, 0, 0, 0;
  const double angle = M_PI / 4;
  EXPECT_LT((lens.Distort({0, 1}) - Vec2(0, angle * (1 + 0.1 * angle * angle))).norm(), 1e-12);
  lens.model = Lens::Model::kDoubleSphere;
  lens.k << 0.8, 0.5, 0, 0;  // n = 24: d1 = 5, 0.8 d1 + 1 = 5, d2 = 7: 1.8 / (3.5 + 2.5)
  EXPECT_LT((lens.Distort({0, std::sqrt(24.0)}) - Vec2(0, 0.3 * std::sqrt(24.0))).norm(), 1e-12);
  lens.model = Lens::Model::kFieldOfView;
  lens.k << M_PI_2, 0, 0, 0;  // 2 tan 45° = 2: atan(2 · 0.5) / 2
  EXPECT_LT((lens.Distort({0, 0.5}) - Vec2(0, M_PI / 8)).norm(), 1e-12);
}

TEST(Lens, UndistortIsTheInverseInTheWholeImage) {
  RenderOptions five = EurocLens();
  five.lens.k3 = -0.02;
  for (const RenderOptions& options : {EurocLens(), five, WideLens(), DoubleSphereLens(), FieldOfViewLens()}) {
    const Calibration& c = options.calibration;
    int described = 0, all = 0;
    for (int v = 0; v < c.height; v += 16) {
      for (int u = 0; u < c.width; u += 16, ++all) {
        const Vec2 x_d = c.Normalized({u, v});
        const std::optional<Vec2> x = options.lens.Undistort(x_d);
        if (!x) continue;
        ++described;
        EXPECT_LT((options.lens.Distort(*x) - x_d).norm(), 1e-8);
      }
    }
    EXPECT_GT(described, 0.75 * all);
  }
}

TEST(Lens, WhatTheModelDoesNotDescribeIsNoRay) {
  Lens lens;
  lens.k << -0.28, 0, 0, 0;  // (1 − 0.28 r²) r is largest at r = 1.09: 0.727
  EXPECT_TRUE(lens.Undistort({0.72, 0}));
  EXPECT_FALSE(lens.Undistort({0.74, 0}));
  lens.model = Lens::Model::kEquidistant;
  lens.k.setZero();
  EXPECT_TRUE(lens.Undistort({1.39, 0}));
  EXPECT_FALSE(lens.Undistort({1.41, 0})) << "80° are 1.396";
}

TEST(Essential, OutliersAreToldFromInliers) {
  Random random(1);
  std::vector<Vec3> f0, f1;
  const Qd R = ExpSO3({0.02, -0.05, 0.03});
  const Vec3 t(0.2, 0.05, -0.1);
  for (int i = 0; i < 120; ++i) {
    const Vec3 p(random.Uniform(-3, 3), random.Uniform(-2, 2), random.Uniform(2, 8));
    const Vec3 noise(random.Normal(), random.Normal(), 0);
    f0.push_back(p.normalized());
    f1.push_back((R * (p + t) + 2e-4 * noise).normalized());
    if (i % 5 == 0)
      f1.back() = (f1.back() + Vec3(0, 0.1, 0)).normalized();  // across the epipolar planes, which lie along x
  }
  std::mt19937 seed;
  const std::vector<bool> inliers = EssentialInliers(f0, f1, 2e-3, &seed);
  int lost = 0;
  for (size_t i = 0; i < inliers.size(); ++i) {
    if (i % 5 == 0) {
      EXPECT_FALSE(inliers[i]) << i;
    } else {
      lost += !inliers[i];
    }
  }
  EXPECT_LE(lost, 4);
}

class RenderedFlight : public testing::Test {
 protected:
  TrackedRecording Follow(RenderOptions options, double seconds) {
    options.path.duration = seconds;
    options.path.standstill_seconds = 1.0;
    WriteRenderedFlight(options, folder_);
    return TrackImages(ReadEurocFolder(folder_));
  }

  test::TemporaryFolder temporary_;
  std::filesystem::path folder_ = temporary_.Path();
};

// The point of the wall at which a track began, as later images must see it [px].
double MedianError(const Recording& recording, const Transform& T_B_C) {
  std::map<int, Vec3> points;
  std::vector<double> errors;
  for (const Image& image : recording.images) {
    const Transform T_W_B = StateAt(recording.truth, image.t)->T_W_B;
    const Qd R_W_C = T_W_B.q * T_B_C.q;
    const Vec3 p_W_C = T_W_B.p + T_W_B.q * T_B_C.p;
    for (const auto& [id, x] : image.tracks) {
      const auto [point, is_new] = points.emplace(id, WallPoint(p_W_C, R_W_C * x.homogeneous()));
      if (is_new) continue;
      const Vec3 p_C = R_W_C.conjugate() * (point->second - p_W_C);
      errors.push_back((p_C.hnormalized() - x).norm() * recording.calibration.FocalLength());
    }
  }
  EXPECT_GT(errors.size(), 80 * recording.images.size());
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  return errors[errors.size() / 2];
}

TEST_F(RenderedFlight, TracksLieWhereTheTruthProjectsThemAndEstimatorsFollow) {
  const RenderOptions options = EurocLens();
  const Recording recording = Follow(options, 6.0).recording;
  ASSERT_EQ(recording.images.size(), 121u);
  EXPECT_LT(MedianError(recording, options.calibration.T_B_C), 0.5);
  for (auto&& policy : AllPolicies()) {
    const std::string name = policy->Name();
    EstimatorOptions estimator;
    estimator.calibration = recording.calibration;
    const OdometryRun run = RunOdometry(recording, estimator, std::move(policy));
    ASSERT_TRUE(run.error) << name;
    EXPECT_GT(run.states.size(), 60u) << name;
    EXPECT_LT(run.error->position_rmse, 0.1) << name;
  }
}

// Each match against the point of the wall that camera 0 sees.
TEST_F(RenderedFlight, ASecondCameraSeesTheSamePointsAndStartsAtRest) {
  const RenderOptions options = StereoLenses();
  const Recording recording = Follow(options, 4.0).recording;
  ASSERT_TRUE(recording.calibration.camera1);
  const Camera& camera1 = *recording.calibration.camera1;
  EXPECT_LT((camera1.T_B_C.p - options.calibration.camera1->T_B_C.p).norm(), 1e-6);
  std::vector<double> errors;
  size_t all = 0;
  for (const Image& image : recording.images) {
    const Transform T_W_B = StateAt(recording.truth, image.t)->T_W_B;
    const auto place = [&](const Transform& T_B_C) -> Transform {
      return {T_W_B.q * T_B_C.q, T_W_B.p + T_W_B.q * T_B_C.p};
    };
    const Transform T_W_C0 = place(options.calibration.T_B_C), T_W_C1 = place(options.calibration.camera1->T_B_C);
    std::map<int, Vec2> in_camera0;
    for (const auto& [id, x] : image.tracks) in_camera0[id] = x;
    all += in_camera0.size();
    for (const auto& [id, x] : image.tracks1) {
      const Vec3 p_W = WallPoint(T_W_C0.p, T_W_C0.q * in_camera0.at(id).homogeneous());
      const Vec3 p_C1 = T_W_C1.q.conjugate() * (p_W - T_W_C1.p);
      errors.push_back((p_C1.hnormalized() - x).norm() * camera1.FocalLength());
    }
  }
  EXPECT_GT(errors.size(), 0.7 * static_cast<double>(all));
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.3);
  EXPECT_LT(errors[errors.size() * 98 / 100], 3.0) << "few are false";
  for (auto&& policy : AllPolicies()) {
    const std::string name = policy->Name();
    const OdometryRun run = RunOdometry(recording, EstimatorOptions{recording.calibration}, std::move(policy));
    ASSERT_TRUE(run.error) << name;
    EXPECT_LT(run.states.front().t, 0.6) << name;
    EXPECT_LT(run.error->position_rmse, 0.05) << name;
  }
}

TEST_F(RenderedFlight, AWideLensIsTrackedAsWell) {
  for (const RenderOptions& options : {WideLens(), DoubleSphereLens(), FieldOfViewLens()}) {
    const Recording recording = Follow(options, 3.0).recording;
    EXPECT_LT(MedianError(recording, options.calibration.T_B_C), 0.5);
    EXPECT_NEAR(recording.calibration.fx, options.calibration.fx, 1e-6);
  }
}

}  // namespace
}  // namespace ch5
