#include "ch5_backend/types/measurements.h"

#include <gtest/gtest.h>

#include "ch5_backend/types/recording.h"

namespace ch5 {
namespace {

// A ramp is its own linear interpolation: 1, 2, 3, 4 at t = 1, 2, 3, 4.
TEST(SamplesBetween, InterpolatesTheEndsAndKeepsTheReadingsBetween) {
  std::vector<ImuMeasurement> ramp;
  for (const double t : {1.0, 2.0, 3.0, 4.0}) ramp.push_back({t, Vec3(t, 0, 0), Vec3(0, 2 * t, 0)});
  const std::vector<ImuSample> samples = SamplesBetween(ramp, 1.25, 3.5);
  ASSERT_EQ(samples.size(), 4u);
  const double t[] = {1.25, 2.0, 3.0, 3.5}, dt[] = {0.0, 0.75, 1.0, 0.5};
  for (int k = 0; k < 4; ++k) {
    EXPECT_DOUBLE_EQ(samples[k].dt, dt[k]);
    EXPECT_DOUBLE_EQ(samples[k].acceleration.x(), t[k]);
    EXPECT_DOUBLE_EQ(samples[k].gyroscope.y(), 2 * t[k]);
  }
  EXPECT_EQ(SamplesBetween(ramp, 2.0, 3.0).size(), 2u);  // ends on measurements: none is doubled
  EXPECT_EQ(SamplesBetween(ramp, 1.0, 4.0).size(), 4u);
  EXPECT_EQ(SamplesBetween(ramp, 2.25, 2.75).size(), 2u);  // between two measurements
}

TEST(SamplesBetween, IsEmptyWhereTheReadingsDoNotReach) {
  const std::vector<ImuMeasurement> two = {{1.0, {}, {}}, {2.0, {}, {}}};
  EXPECT_TRUE(SamplesBetween(two, 0.9, 1.5).empty());
  EXPECT_TRUE(SamplesBetween(two, 1.5, 2.1).empty());
  EXPECT_TRUE(SamplesBetween(two, 1.5, 1.5).empty());
  EXPECT_TRUE(SamplesBetween(two, 1.5, std::nan("")).empty());
  EXPECT_TRUE(SamplesBetween({}, 0.0, 1.0).empty());
}

TEST(StateAt, TurnsHalfWayHalfTheAngleAndEndsWhereTheTruthEnds) {
  std::vector<StampedState> states(2);
  states[0].t = 1.0;
  states[1].t = 2.0;
  states[1].T_W_B = {ExpSO3(Vec3(0, 0, 1.0)), Vec3(2, 4, 6)};
  states[1].v_W = Vec3(1, 1, 1);
  const std::optional<StampedState> middle = StateAt(states, 1.5);
  ASSERT_TRUE(middle);
  EXPECT_LT((LogSO3(middle->T_W_B.q) - Vec3(0, 0, 0.5)).norm(), 1e-15);
  EXPECT_EQ(middle->T_W_B.p, Vec3(1, 2, 3));
  EXPECT_EQ(middle->v_W, Vec3(0.5, 0.5, 0.5));
  EXPECT_TRUE(StateAt(states, 1.0) && StateAt(states, 2.0));
  EXPECT_FALSE(StateAt(states, 0.999) || StateAt(states, 2.001) || StateAt({}, 0.0));
  states[1].t = 3.0;
  EXPECT_TRUE(StateAt(states, 3.0));
  EXPECT_FALSE(StateAt(states, 2.0)) << "nobody knows what was between";
}

TEST(Recording, NanosecondsSurviveTheirTimeAsADouble) {
  constexpr int64_t kOrigin = 1403715273262143232;
  for (const int64_t after : {int64_t{1}, int64_t{49999872}, int64_t{2999999999999}, int64_t{864000000000001}}) {
    EXPECT_EQ(NanosecondsAt(SecondsAt(kOrigin + after, kOrigin), kOrigin), kOrigin + after);
  }
}

// By hand: one focal length beside the axis is one unit of the normalized plane.
TEST(Calibration, PixelsAndTheNormalizedPlaneAreInverse) {
  Calibration calibration;
  calibration.fx = 400.0, calibration.fy = 500.0, calibration.cx = 320.0, calibration.cy = 240.0;
  EXPECT_EQ(calibration.Pixel(Vec2(0, 0)), Vec2(320, 240));
  EXPECT_EQ(calibration.Pixel(Vec2(1, -1)), Vec2(720, -260));
  const Vec2 x(-0.31, 0.17);
  EXPECT_LT((calibration.Normalized(calibration.Pixel(x)) - x).norm(), 1e-16);
  EXPECT_EQ(calibration.GravityInWorld(), Vec3(0, 0, -9.81));
}

}  // namespace
}  // namespace ch5
