#include "ch5_backend/simulate/sensors/trajectory.h"

#include <gtest/gtest.h>

#include "ch5_backend/simulate/mono_ba.h"
#include "ch5_backend/simulate/sensors/paths.h"
#include "ch5_backend/simulate/sensors/spline.h"
#include "tests/simulate/course_arc.h"

namespace ch5 {
namespace {

std::vector<std::pair<std::string, Trajectory>> AllPaths() {
  HandheldOptions handheld;
  handheld.duration = 10.0;
  return {{"course arc", CourseArc(10.0)},
          {"sine", GaugePaperPath(GaugePath::kSine)},
          {"arc", GaugePaperPath(GaugePath::kArc)},
          {"rectangle", GaugePaperPath(GaugePath::kRectangle)},
          {"handheld", Handheld(handheld)}};
}

// Marsden's identity: control points on the line c_k = k make the line u + 2 (the mean of the knots that shape it).
TEST(Spline, ControlPointsOnALineGiveTheLine) {
  const Spline line({0, 1, 2, 3, 4, 5, 6, 7}, 10.0, 0.5);
  for (const double t : {10.0, 10.3, 11.0, 11.5}) {
    const Jet x = line(Jet::Time(t));
    EXPECT_NEAR(x.value, (t - 10.0) / 0.5 + 2.0, 1e-14);
    EXPECT_NEAR(x.rate, 2.0, 1e-13);
    EXPECT_NEAR(x.second, 0.0, 1e-12);
  }
}

// The basis at a knot of the uniform quintic B-spline is (1, 26, 66, 26, 1)/120, its rate (−1, −10, 0, 10, 1)/24.
TEST(Spline, BasisAtAKnotIsTheTabulatedOne) {
  const double basis[] = {1, 26, 66, 26, 1, 0}, rate[] = {-1, -10, 0, 10, 1, 0};
  for (int k = 0; k < 6; ++k) {
    std::vector<double> c(6, 0.0);
    c[k] = 1.0;
    const Jet x = Spline(c, 0.0, 1.0)(Jet::Time(0.0));
    EXPECT_NEAR(x.value, basis[k] / 120.0, 1e-15) << k;
    EXPECT_NEAR(x.rate, rate[k] / 24.0, 1e-15) << k;
  }
}

TEST(Spline, PiecesMeetWithTwoDerivatives) {
  const Spline spline({0.3, -1, 2, 0.5, 4, -3, 1, 2}, 0.0, 0.4);
  const Jet before = spline(Jet::Time(0.4 - 1e-9)), after = spline(Jet::Time(0.4 + 1e-9));
  EXPECT_NEAR(before.value, after.value, 1e-7);
  EXPECT_NEAR(before.rate, after.rate, 1e-6);
  EXPECT_NEAR(before.second, after.second, 1e-5);  // the third derivative is of order 1e3
}

TEST(Spline, RefusesTooFewPointsAndASpacingThatIsNotPositive) {
  EXPECT_THROW(Spline({1, 2, 3, 4, 5}, 0.0, 1.0), std::invalid_argument);
  EXPECT_THROW(Spline({1, 2, 3, 4, 5, 6}, 0.0, 0.0), std::invalid_argument);
  EXPECT_THROW(Spline({1, 2, 3, 4, 5, 6}, 0.0, std::nan("")), std::invalid_argument);
}

// Central differences over 2h have an error ~ h²/6 · third derivative (≤ 1e3 here): 1e-7 with h = 1e-5, and rounding
// adds ε/h ≈ 1e-10.
TEST(Trajectory, VelocityAccelerationAndRateAreTheDerivativesOfThePose) {
  constexpr double h = 1e-5, kTolerance = 1e-6;
  for (const auto& [name, trajectory] : AllPaths()) {
    for (int k = 1; k < 20; ++k) {
      const double t = trajectory.Duration() * k / 20.0 + 1e-3;  // off the splines' knots
      const Motion before = trajectory.At(t - h), now = trajectory.At(t), after = trajectory.At(t + h);
      EXPECT_LT(((after.T_W_B.p - before.T_W_B.p) / (2 * h) - now.v_W).norm(), kTolerance) << name << " " << t;
      EXPECT_LT(((after.v_W - before.v_W) / (2 * h) - now.a_W).norm(), kTolerance) << name << " " << t;
      const Vec3 turn = LogSO3(before.T_W_B.q.conjugate() * after.T_W_B.q);
      EXPECT_LT((turn / (2 * h) - now.omega_B).norm(), kTolerance) << name << " " << t;
      EXPECT_NEAR(now.T_W_B.q.norm(), 1.0, 1e-14);
    }
  }
}

TEST(Trajectory, CourseArcPassesThroughTheFramesOfTheCourse) {
  MonoBaOptions options;
  options.frames = 5;
  const MonoBaScene scene = SimulateMonoBa(options);
  const Trajectory arc = CourseArc(10.0);
  for (int n = 0; n < options.frames; ++n) {
    const Transform T_W_B = arc.At(10.0 * n / options.frames).T_W_B;
    EXPECT_LT((T_W_B.p - scene.frames[n].p).norm(), 1e-14);
    EXPECT_LT(LogSO3(T_W_B.q.conjugate() * scene.frames[n].q).norm(), 1e-14);
  }
}

TEST(Trajectory, GaugePaperPathsAreFiveMetersAtTwoMetersASecond) {
  for (const GaugePath path : {GaugePath::kSine, GaugePath::kArc, GaugePath::kRectangle}) {
    const Trajectory trajectory = GaugePaperPath(path);
    EXPECT_NEAR(PathLength(trajectory), 5.0, 1e-9);
    EXPECT_EQ(trajectory.Duration(), 2.5);
    // Flyable: B's x axis looks toward +y, accelerations stay below a racing drone's.
    for (double t = 0.0; t <= 2.5; t += 0.05) {
      const Motion motion = trajectory.At(t);
      EXPECT_GT((motion.T_W_B.q * Vec3::UnitX()).y(), 0.3);
      EXPECT_LT(motion.a_W.norm(), 30.0);
    }
  }
}

TEST(Trajectory, HandheldStandsStillFirstAndThenSetsOffSmoothly) {
  HandheldOptions options;
  options.duration = 10.0;
  options.standstill_seconds = 4.0;
  const Trajectory trajectory = Handheld(options);
  for (const double t : {0.0, 1.3, 3.99}) {
    EXPECT_LT((trajectory.At(t).T_W_B.p - trajectory.At(0.0).T_W_B.p).norm(), 1e-14);
    EXPECT_LT(trajectory.At(t).v_W.norm() + trajectory.At(t).omega_B.norm(), 1e-13);
    EXPECT_LT(trajectory.At(t).a_W.norm(), 1e-12);
  }
  EXPECT_LT(trajectory.At(4.05).a_W.norm(), 0.05);
  EXPECT_GT(trajectory.At(6.0).v_W.norm() + trajectory.At(7.0).v_W.norm(), 0.1);
}

TEST(Trajectory, HandheldRepeatsWithItsSeedAndDiffersWithAnother) {
  HandheldOptions a, b;
  b.seed = 2;
  EXPECT_EQ(Handheld(a).At(7.0).T_W_B.p, Handheld(a).At(7.0).T_W_B.p);
  EXPECT_GT((Handheld(a).At(7.0).T_W_B.p - Handheld(b).At(7.0).T_W_B.p).norm(), 1e-3);
  a.knot_spacing = 0.0;
  EXPECT_THROW(Handheld(a), std::invalid_argument);
}

}  // namespace
}  // namespace ch5
