/// An estimator in a thread of its own gives what one thread gives, whatever arrives when.
#include "ch5_backend/window/live_estimator.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "tests/window/simulations.h"

namespace ch5 {
namespace {

Recording SimulateFourSeconds() { return SimulateRoom({4.0, /*standstill_seconds=*/1.5, /*max_tracks=*/30}); }

std::vector<StampedState> InOneThread(const Recording& recording) {
  return RunOdometry(recording, EstimatorOptions{recording.calibration}, MakeVinsPolicy()).states;
}

void ExpectSame(const std::vector<StampedState>& states, const std::vector<StampedState>& expected) {
  EXPECT_GT(states.size(), 20u);
  EXPECT_TRUE(AreSame(states, expected));
}

TEST(LiveEstimator, TwoThreadsFeedItToTheSameBits) {
  const Recording recording = SimulateFourSeconds();
  std::vector<StampedState> states;
  size_t reports = 0;
  LiveEstimator live(EstimatorOptions{recording.calibration}, MakeVinsPolicy(),
                     [&](const FrameReport& report, const Estimator&) {
                       ++reports;
                       EXPECT_EQ(report.message.empty(), report.state.has_value()) << "no image without a reason";
                       if (report.state) states.push_back(*report.state);
                     });
  std::thread driver([&] {
    for (const ImuMeasurement& measurement : recording.imu) live.AddImu(measurement);
  });
  std::thread tracker([&] {
    for (const Image& image : recording.images) live.AddFrame(image);
  });
  for (int k = 0; k < 1000; ++k) live.PredictAt(0.004 * k);  // a third thread reads
  driver.join();
  tracker.join();
  live.Finish();
  EXPECT_EQ(reports, recording.images.size());
  ExpectSame(states, InOneThread(recording));
}

TEST(LiveEstimator, AllImagesBeforeAllReadingsGiveTheSameBits) {
  const Recording recording = SimulateFourSeconds();
  std::vector<StampedState> states;
  LiveEstimator live(EstimatorOptions{recording.calibration}, MakeVinsPolicy(),
                     [&](const FrameReport& report, const Estimator&) {
                       if (report.state) states.push_back(*report.state);
                     });
  for (const Image& image : recording.images) live.AddFrame(image);
  for (const ImuMeasurement& measurement : recording.imu) live.AddImu(measurement);
  live.Finish();
  ExpectSame(states, InOneThread(recording));
}

TEST(LiveEstimator, PredictsFromTheNewestEstimate) {
  const Recording recording = SimulateFourSeconds();
  std::optional<StampedState> newest, predicted;
  LiveEstimator live(EstimatorOptions{recording.calibration}, MakeVinsPolicy(),
                     [&](const FrameReport& report, const Estimator& estimator) {
                       newest = report.state;
                       if (newest) predicted = estimator.PredictAt(newest->t + 0.004);
                     });
  EXPECT_FALSE(live.PredictAt(1.0));
  for (const ImuMeasurement& measurement : recording.imu) live.AddImu(measurement);
  for (const Image& image : recording.images) {
    if (image.t < recording.imu.back().t - 0.5) live.AddFrame(image);
  }
  live.Finish();
  ASSERT_TRUE(newest && predicted);
  EXPECT_EQ(live.PredictAt(newest->t)->T_W_B.p, newest->T_W_B.p);
  EXPECT_LT((live.PredictAt(newest->t + 0.004)->T_W_B.p - predicted->T_W_B.p).norm(), 1e-5)
      << "it knows measurements after";
  EXPECT_TRUE(live.PredictAt(newest->t + 0.4)) << "the measurements reach so far";
}

TEST(LiveEstimator, RefusesAMeasurementWhereItIsFed) {
  LiveEstimator live(EstimatorOptions{}, MakeVinsPolicy(), nullptr);
  live.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()});
  EXPECT_THROW(live.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()}), MeasurementError);
  live.AddFrame({1.0, {}});
  EXPECT_THROW(live.AddFrame({0.5, {}}), MeasurementError);
  EXPECT_NO_THROW(live.Finish());
}

TEST(LiveEstimator, WhatTheCallbackThrowsComesOutWhereItIsFed) {
  LiveEstimator live(EstimatorOptions{}, MakeVinsPolicy(),
                     [](const FrameReport&, const Estimator&) { throw std::runtime_error("no disk"); });
  live.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()});
  live.AddFrame({0.5, {}});
  EXPECT_THROW(live.Finish(), std::runtime_error);
  EXPECT_THROW(live.AddImu({2.0, Vec3(0, 0, 9.81), Vec3::Zero()}), std::runtime_error);
}

TEST(LiveEstimator, ACallbackThatWaitsForItselfIsToldSo) {
  LiveEstimator* self = nullptr;
  LiveEstimator live(EstimatorOptions{}, MakeVinsPolicy(),
                     [&](const FrameReport&, const Estimator&) { self->Finish(); });
  self = &live;
  live.AddImu({1.0, Vec3(0, 0, 9.81), Vec3::Zero()});
  live.AddFrame({0.5, {}});
  EXPECT_THROW(live.Finish(), std::logic_error);
}

TEST(LiveEstimator, EndsWithImagesThatWait) {
  LiveEstimator live(EstimatorOptions{}, MakeVinsPolicy(), nullptr);
  live.AddFrame({1.0, {}});
}

std::vector<ImuMeasurement> AtRest(double from, double until) {
  std::vector<ImuMeasurement> imu;
  for (double t = from; t < until; t += 0.005) imu.push_back({t, Vec3(0, 0, 9.81), Vec3::Zero()});
  return imu;
}

TEST(LiveEstimator, ASilentImuDoesNotHoldImagesForEver) {
  std::atomic<int> reports = 0;
  LiveOptions options;
  options.patience = 0.05;
  LiveEstimator live(
      EstimatorOptions{}, MakeVinsPolicy(), [&](const FrameReport&, const Estimator&) { ++reports; }, options);
  for (int k = 0; k < 300; ++k) live.AddFrame({0.1 * k, {}});
  while (live.GetBacklog().waiting > 0) std::this_thread::yield();  // without Finish; or the test does not end
  live.Finish();
  EXPECT_EQ(reports, 300);
}

// However far the images run ahead of a measurement that comes in the end.
TEST(LiveEstimator, ImagesHalfAMinuteAheadWaitForTheirReadings) {
  std::vector<std::string> messages, expected;
  LiveEstimator live(EstimatorOptions{}, MakeVinsPolicy(),
                     [&](const FrameReport& report, const Estimator&) { messages.push_back(report.message); });
  Estimator one(EstimatorOptions{}, MakeVinsPolicy());
  for (int k = 0; k < 300; ++k) live.AddFrame({0.1 * k, {}});
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(live.GetBacklog().waiting, 300u);
  const std::vector<ImuMeasurement> imu = AtRest(0.0, 30.0);
  for (const ImuMeasurement& measurement : imu) live.AddImu(measurement);
  live.Finish();
  size_t fed = 0;
  for (int k = 0; k < 300; ++k) {
    for (; fed < imu.size() && (fed == 0 || imu[fed - 1].t < 0.1 * k); ++fed) one.AddImu(imu[fed]);
    expected.push_back(one.AddFrame({0.1 * k, {}}).message);
  }
  EXPECT_EQ(messages, expected);
}

TEST(LiveEstimator, WhoCannotKeepUpDropsImagesAndIsNeverLate) {
  constexpr double kMaxLag = 0.5, kPeriod = 0.1;
  LiveOptions options;
  options.max_lag = kMaxLag;
  std::atomic<bool> goes_on = false;
  size_t reports = 0;
  LiveEstimator live(
      EstimatorOptions{}, MakeVinsPolicy(),
      [&](const FrameReport&, const Estimator&) {
        ++reports;
        while (!goes_on) std::this_thread::yield();  // a solve that takes as long as all images
      },
      options);
  for (const ImuMeasurement& measurement : AtRest(0.0, 30.1)) live.AddImu(measurement);
  live.AddFrame({0.0, {}});
  while (live.GetBacklog().waiting > 0) std::this_thread::yield();
  for (int k = 1; k <= 300; ++k) live.AddFrame({kPeriod * k, {}});
  EXPECT_EQ(live.GetBacklog().waiting, 300u);
  EXPECT_DOUBLE_EQ(live.GetBacklog().seconds, 30.0);
  goes_on = true;
  live.Finish();
  const Backlog end = live.GetBacklog();
  EXPECT_EQ(end.waiting, 0u);
  EXPECT_EQ(end.seconds, 0.0);
  EXPECT_EQ(reports + end.dropped, 301u);
  EXPECT_NEAR(static_cast<double>(reports), 1 + kMaxLag / kPeriod + 1, 1.1)
      << "the first one, and those within the lag";
}

TEST(LiveEstimator, GoesOnAfterARestartWhenClocksJumpBack) {
  const Recording recording = SimulateFourSeconds();
  std::vector<StampedState> states;
  std::vector<int> segments;
  LiveEstimator live(EstimatorOptions{recording.calibration}, MakeVinsPolicy(),
                     [&](const FrameReport& report, const Estimator&) {
                       if (!report.state) return;
                       states.push_back(*report.state);
                       segments.push_back(report.segment);
                     });
  const auto feed = [&] {
    for (const ImuMeasurement& measurement : recording.imu) live.AddImu(measurement);
    for (const Image& image : recording.images) live.AddFrame(image);
    live.Finish();
  };
  feed();
  EXPECT_THROW(live.AddImu(recording.imu.front()), MeasurementError);
  live.Restart();
  EXPECT_FALSE(live.PredictAt(recording.images.back().t));
  feed();
  const size_t half = states.size() / 2;
  ASSERT_GT(half, 20u);
  EXPECT_EQ(states.size(), 2 * half);
  EXPECT_EQ(segments.front(), 0);
  EXPECT_EQ(segments.back(), 1);
  EXPECT_LT((states.back().v_W - states[half - 1].v_W).norm(), 0.05) << "the same flight, laid upon the last position";
}

TEST(LiveEstimator, NothingIsPredictedLongerThanTheImuMayCarry) {
  const Recording recording = SimulateFourSeconds();
  EstimatorOptions options{recording.calibration};
  LiveEstimator live(options, MakeVinsPolicy(), nullptr);
  for (const ImuMeasurement& measurement : recording.imu) live.AddImu(measurement);
  for (const Image& image : recording.images) live.AddFrame(image);
  live.Finish();
  const double end = recording.imu.back().t, most = recording.images.back().t + options.weights.max_imu_seconds;
  for (const ImuMeasurement& measurement : AtRest(end + 0.005, most + 1.0)) live.AddImu(measurement);
  EXPECT_TRUE(live.PredictAt(most - 0.01));
  EXPECT_FALSE(live.PredictAt(most + 0.01));
}

}  // namespace
}  // namespace ch5
