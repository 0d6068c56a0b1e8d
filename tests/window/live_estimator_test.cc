/// An estimator in a thread of its own gives what one thread gives, whatever arrives when.
#include "ch5_backend/window/live_estimator.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/window/simulations.h"

namespace ch5 {
namespace {

Recording SimulateFourSeconds() {
  RoomOptions room;
  room.duration = 4.0;
  room.standstill_seconds = 1.5;
  room.max_tracks = 30;
  return SimulateRoom(room);
}

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

TEST(LiveEstimator, ASilentImuDoesNotHoldImagesForEver) {
  int restarted_or_waiting = 0;
  {
    LiveEstimator live(EstimatorOptions{}, MakeVinsPolicy(),
                       [&](const FrameReport& report, const Estimator&) { restarted_or_waiting += !report.state; });
    for (int k = 0; k < 300; ++k) live.AddFrame({0.1 * k, {}});
    live.Finish();
  }
  EXPECT_EQ(restarted_or_waiting, 300);
}

}  // namespace
}  // namespace ch5
