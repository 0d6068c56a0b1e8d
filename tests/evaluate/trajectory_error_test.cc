#include "ch5_backend/evaluate/trajectory_error.h"

#include <cmath>

#include <gtest/gtest.h>

#include "ch5_backend/evaluate/relative_error.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/simulate/sensors/paths.h"

namespace ch5 {
namespace {

std::vector<StampedState> Truth() {
  const Trajectory trajectory = Handheld({});
  std::vector<StampedState> truth;
  for (int k = 0; k <= 600; ++k) {
    const Motion motion = trajectory.At(0.05 * k);
    truth.push_back({0.05 * k, motion.T_W_B, motion.v_W, Vec3::Zero(), Vec3::Zero()});
  }
  return truth;
}

std::vector<StampedState> Moved(const YawTransform& by, std::vector<StampedState> states) {
  for (StampedState& state : states) {
    state.T_W_B = by * state.T_W_B;
    state.v_W = by.Rotation() * state.v_W;
  }
  return states;
}

YawTransform Move(double yaw, const Vec3& p) {
  YawTransform move;
  move.yaw = yaw;
  move.p = p;
  return move;
}

std::vector<Vec3> Positions(const std::vector<StampedState>& states) {
  std::vector<Vec3> positions;
  for (const StampedState& state : states) positions.push_back(state.T_W_B.p);
  return positions;
}

// By hand: a quarter turn takes (1, 0) to (0, 1).
TEST(AlignYaw, TurnsAQuarter) {
  const auto found = AlignYaw({Vec3(0, 0, 0), Vec3(1, 0, 5)}, {Vec3(2, 3, 4), Vec3(2, 4, 9)});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->yaw, M_PI / 2, 1e-15);
  EXPECT_LT((found->p - Vec3(2, 3, 4)).norm(), 1e-15);
}

TEST(AlignYaw, RecoversAKnownTransform) {
  const std::vector<StampedState> truth = Truth();
  for (const double yaw : {-3.1, -1.0, 0.0, 0.5, 3.0}) {
    const YawTransform move = Move(yaw, Vec3(10, -20, 3));
    const auto found = AlignYaw(Positions(truth), Positions(Moved(move, truth)));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->yaw, yaw, 1e-12);
    EXPECT_LT((found->p - move.p).norm(), 1e-11);
  }
}

// At a minimum, any small change of any of the four freedoms makes the sum of squares larger.
TEST(AlignYaw, IsTheMinimumOfTheSumOfSquares) {
  Random random(4);
  std::vector<Vec3> from, to;
  for (int k = 0; k < 50; ++k) {
    from.push_back(NormalVector(&random, 2.0));
    to.push_back(Move(0.7, Vec3(1, 2, 3)) * from.back() + NormalVector(&random, 0.3));
  }
  const auto cost = [&](const YawTransform& T) {
    double sum = 0.0;
    for (size_t k = 0; k < from.size(); ++k) sum += (to[k] - T * from[k]).squaredNorm();
    return sum;
  };
  const YawTransform best = *AlignYaw(from, to);
  for (const double step : {-1e-3, 1e-3}) {
    YawTransform turned = best;
    turned.yaw += step;
    EXPECT_GT(cost(turned), cost(best));
    for (int i = 0; i < 3; ++i) {
      YawTransform shifted = best;
      shifted.p[i] += step;
      EXPECT_GT(cost(shifted), cost(best));
    }
  }
}

TEST(AlignYaw, SaysSoWhereTheYawIsNotDetermined) {
  const std::vector<Vec3> tower = {Vec3(1, 2, 0), Vec3(1, 2, 1), Vec3(1, 2, 5)};
  const std::vector<Vec3> walk = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 1, 0)};
  EXPECT_FALSE(AlignYaw(tower, tower));
  EXPECT_FALSE(AlignYaw({}, {}));
  EXPECT_FALSE(AlignYaw({Vec3(1, 2, 3)}, {Vec3(1, 2, 3)}));
  EXPECT_FALSE(AlignYaw(walk, {walk[0], walk[1]}));
  EXPECT_FALSE(AlignYaw(walk, {walk[0], Vec3(NAN, 0, 0), walk[2]}));
  EXPECT_TRUE(AlignYaw(walk, walk));
}

TEST(AlignFirstPose, LaysPositionAndYawUponEachOther) {
  const Transform first = Truth()[100].T_W_B;
  const YawTransform move = Move(2.0, Vec3(5, 6, 7));
  const YawTransform found = AlignFirstPose(first, move * first);
  EXPECT_NEAR(found.yaw, 2.0, 1e-14);
  EXPECT_LT((found.p - move.p).norm(), 1e-13);
}

TEST(TrajectoryError, DoesNotDependOnTheGaugeOfTheEstimate) {
  const std::vector<StampedState> truth = Truth();
  std::vector<StampedState> estimate = truth;
  Random random(9);
  for (StampedState& state : estimate) {
    state.T_W_B = {state.T_W_B.q * ExpSO3(NormalVector(&random, 0.01)), state.T_W_B.p + NormalVector(&random, 0.05)};
    state.v_W += NormalVector(&random, 0.02);
  }
  const auto a = CompareTrajectories(estimate, truth);
  const auto b = CompareTrajectories(Moved(Move(1.2, Vec3(-4, 5, 6)), estimate), truth);
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->position_rmse, b->position_rmse, 1e-12);
  EXPECT_NEAR(a->rotation_rmse, b->rotation_rmse, 1e-12);
  EXPECT_NEAR(a->yaw_rmse, b->yaw_rmse, 1e-12);
  EXPECT_NEAR(a->velocity_rmse, b->velocity_rmse, 1e-12);
  // 601 draws: the root mean squares are σ√3 (σ for the yaw alone) within 1/√(2·601) ≈ 3 %, three times that allowed.
  EXPECT_NEAR(a->position_rmse, 0.05 * std::sqrt(3.0), 0.09 * 0.087);
  EXPECT_NEAR(a->rotation_rmse, 0.01 * std::sqrt(3.0), 0.09 * 0.0173);
  EXPECT_NEAR(a->yaw_rmse, 0.01, 0.09 * 0.01);
  EXPECT_NEAR(a->velocity_rmse, 0.02 * std::sqrt(3.0), 0.09 * 0.0346);
}

// By hand: aligned at the first pose, errors 0, 1 and 2 m have the root mean square √(5/3).
TEST(TrajectoryError, IsTheRootMeanSquareOfTheDistances) {
  std::vector<StampedState> truth(3), estimate(3);
  for (int k = 0; k < 3; ++k) {
    truth[k].t = estimate[k].t = k;
    truth[k].T_W_B.p = Vec3(k, 0, 0);
    estimate[k].T_W_B.p = Vec3(2 * k, 0, 0);
  }
  const auto error = CompareTrajectories(estimate, truth, AlignFirstPose(estimate[0].T_W_B, truth[0].T_W_B));
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->position_rmse, std::sqrt(5.0 / 3.0), 1e-15);
  EXPECT_EQ(error->position_max, 2.0);
  EXPECT_EQ(error->time, (std::vector<double>{0, 1, 2}));
}

TEST(TrajectoryError, NamesTheScaleThatWouldFit) {
  const std::vector<StampedState> truth = Truth();
  std::vector<StampedState> estimate = Moved(Move(0.3, Vec3(1, 2, 3)), truth);
  for (StampedState& state : estimate) state.T_W_B.p *= 0.98;
  const auto error = CompareTrajectories(estimate, truth);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->scale, 1.0 / 0.98, 1e-12);
  EXPECT_NEAR(CompareTrajectories(truth, truth)->scale, 1.0, 1e-12);
}

TEST(TrajectoryError, ComparesOnlyWhereTheTruthIsKnown) {
  const std::vector<StampedState> truth = Truth();
  std::vector<StampedState> estimate = truth;
  for (StampedState& state : estimate) state.t += 29.0;
  const auto error = CompareTrajectories(estimate, truth);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->position.size(), 21u);  // 29 … 30 s, every 0.05 s
  EXPECT_FALSE(CompareTrajectories(estimate, {}));
  EXPECT_FALSE(CompareTrajectories({}, truth));
}

// A walk along x at 1 m/s for 30 s, of which the estimate takes 2 % too much.
std::vector<StampedState> Walk(double scale) {
  std::vector<StampedState> states;
  for (int k = 0; k <= 300; ++k) {
    states.emplace_back();
    states.back().t = 0.1 * k;
    states.back().T_W_B.p.x() = scale * 0.1 * k;
  }
  return states;
}

TEST(TrajectoryError, OfTwoPosesHasNoScale) {
  const std::vector<StampedState> walk = Walk(1.0);
  EXPECT_TRUE(std::isnan(CompareTrajectories({walk[0], walk[9]}, walk)->scale));
}

TEST(RelativeError, OfAWalkWhoseScaleIsWrong) {
  const auto error = CompareMotions(Walk(1.02), Walk(1.0));
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->position_rmse, 0.02, 1e-12);
  EXPECT_NEAR(error->path, 30.0, 1e-9);
  EXPECT_NEAR(error->DriftPercent(), 2.0, 1e-9);
  EXPECT_TRUE(std::isnan(CompareMotions(Walk(0.1), Walk(0.0))->DriftPercent())) << "the truth turns on the spot";
}

TEST(ErrorsOverLengths, OfAWalkWhoseScaleIsWrongGrowWithTheLength) {
  const std::vector<StampedState> truth = Walk(1.0);  // 30 m, 0.1 m a state
  const auto errors = ErrorsOverLengths({Walk(1.02)}, truth, {0.1005, 0.5005, 1.1});
  ASSERT_EQ(errors.size(), 3U);
  EXPECT_NEAR(errors[0].length, 3.015, 1e-9);
  ASSERT_EQ(errors[0].position.size(), 300U - 30U);  // every state begins one but the last 31 of 301
  ASSERT_EQ(errors[1].position.size(), 300U - 150U);
  for (const double error : errors[0].position) EXPECT_NEAR(error, 0.02 * 3.1, 1e-9);  // the first state beyond 3.015 m
  for (const double error : errors[1].position) EXPECT_NEAR(error, 0.02 * 15.1, 1e-9);
  for (const double error : errors[1].yaw) EXPECT_NEAR(error, 0.0, 1e-12);
  EXPECT_TRUE(errors[2].position.empty()) << "no piece is longer than the path";
  EXPECT_TRUE(std::isnan(QuantileOfSorted(errors[2].position, 0.5)));
}

TEST(ErrorsOverLengths, NoPieceSpansTwoSegments) {
  const std::vector<StampedState> truth = Walk(1.0);
  std::vector<StampedState> first(truth.begin(), truth.begin() + 100), second(truth.begin() + 100, truth.end());
  for (StampedState& state : second) state.T_W_B.p.y() += 5.0;  // a world frame of its own
  const auto errors = ErrorsOverLengths({first, second}, truth, {0.2});
  ASSERT_EQ(errors.size(), 1U);
  ASSERT_FALSE(errors[0].position.empty());
  EXPECT_NEAR(errors[0].position.back(), 0.0, 1e-9);
  EXPECT_TRUE(ErrorsOverLengths({first}, {}, {0.2}).empty()) << "there is no truth";
}

TEST(RelativeError, ATruthOfBothEndsTellsTheDrift) {
  std::vector<StampedState> truth = Walk(1.0);
  truth.erase(truth.begin() + 50, truth.begin() + 250);  // as a motion capture system in one room of many
  for (StampedState& state : truth) state.T_W_B.p.y() = state.t > 20.0 ? 3.0 : 0.0;  // which no line between them shows
  std::vector<StampedState> estimate = Walk(1.02);
  for (StampedState& state : estimate) state.T_W_B.p.y() = state.t > 20.0 ? 3.0 : 0.0;
  const auto error = CompareMotions(estimate, truth);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->position_rmse, 0.02, 1e-12) << "no interval goes over the gap";
  EXPECT_NEAR(error->path, 4.9 + 5.0 + 1.02 * 20.1 + std::hypot(1.02 * 0.1, 3.0) - 1.02 * 0.1, 1e-9);
  EXPECT_NEAR(error->end, 0.6, 1e-9);
  EXPECT_EQ(CompareTrajectories(estimate, truth)->position.size(), 101u);
}

}  // namespace
}  // namespace ch5
