#include "ch5_backend/experiments/studies/implausible_images.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <stdexcept>

#include "ch5_backend/simulate/sensors/simulation.h"
#include "tests/experiments/warning_names.h"
#include "tests/window/simulations.h"

namespace ch5 {
namespace {

// As a camera sends them that stalls, or that is asked twice as often as it takes images.
TEST(ImplausibleImages, ImagesThatRepeatTheOneBeforeAreLeftOutAndNamed) {
  const Recording healthy = SimulateRoom({10.0});
  for (const size_t every : {size_t{0}, size_t{2}}) {
    Recording recording = healthy;
    size_t copies = 0;
    for (size_t k = 1; k < recording.images.size(); ++k) {
      const bool repeats = every == 0 ? k > 100 && k < 120 : k % every == 1 && k + 1 < recording.images.size();
      if (!repeats) continue;
      recording.images[k].tracks = recording.images[k - 1].tracks;
      ++copies;
    }
    const RecordingWarnings warnings = CheckImages(false, &recording);
    ASSERT_EQ(Names(warnings), "images_repeated");
    EXPECT_EQ(warnings[0].value, static_cast<double>(copies));
    EXPECT_EQ(recording.images.size(), healthy.images.size() - copies);
    recording.images[60].tracks = recording.images[59].tracks;
    EXPECT_THROW(CheckImages(true, &recording), std::invalid_argument);
  }
}

// As dirt on the lens, or the vehicle's own hood, that is tracked like the scene; at rest all points stay.
TEST(ImplausibleImages, PointsThatStayWhileTheCameraTurnsAreLeftOutAndNamed) {
  RoomOptions options;
  options.standstill_seconds = 3.0;
  const Recording healthy = SimulateRoom(options);
  Recording recording = healthy;
  EXPECT_EQ(Names(CheckTracks(true, &recording)), "");
  std::map<int, Vec2> places;
  size_t still = 0, all = 0;
  for (Image& image : recording.images) {
    for (TrackedPoint& point : image.tracks) {
      ++all;
      if (point.id % 5 != 0) continue;
      ++still;
      point.x = places.emplace(point.id, point.x).first->second;
    }
  }
  const RecordingWarnings warnings = CheckTracks(false, &recording);
  ASSERT_EQ(Names(warnings), "fixed_points");
  EXPECT_EQ(warnings[0].other, static_cast<double>(all));
  EXPECT_GT(warnings[0].value, 0.8 * static_cast<double>(still)) << "but for tracks of a moment";
  for (const Image& image : recording.images)
    for (const TrackedPoint& point : image.tracks) all -= point.id % 5 != 0 ? 1 : 0;
  EXPECT_EQ(all, still) << "no other point is left out";
}

// A tracker with 40 places that gives a place's number to the next point; a false match from which a track comes back is none.
TEST(ImplausibleImages, AnIdThatGoesOnWithAnotherPointIsSplitAndNamed) {
  RoomOptions options;
  options.simulation.camera.max_tracks = 40;
  options.simulation.camera.outlier_fraction = 0.02;
  options.simulation.camera.drop_probability = 0.01;
  options.simulation.calibration = ForwardStereo();
  const Recording whole = SimulateRoom(options);
  Recording recording = whole;
  EXPECT_EQ(Names(CheckTracks(true, &recording)), "");
  std::map<int, int> places, ids;  // by id, by place
  for (Image& image : recording.images) {
    std::map<int, int> still;
    for (const TrackedPoint& point : image.tracks)
      if (const auto place = places.find(point.id); place != places.end()) still[place->second] = point.id;
    places.clear();
    for (const auto& [place, id] : still) places[id] = place;
    int next = 0;
    for (TrackedPoint& point : image.tracks) {
      if (places.count(point.id) == 0) {
        while (still.count(next) > 0) ++next;
        still[next] = point.id;
        places[point.id] = next;
      }
      point.id = places[point.id];
    }
    for (TrackedPoint& point : image.tracks1) point.id = places.at(point.id);
  }
  Recording strict = recording;  // stays as it is
  EXPECT_THROW(CheckTracks(true, &strict), std::invalid_argument);
  const RecordingWarnings warnings = CheckTracks(false, &recording);
  ASSERT_EQ(Names(warnings), "ids_reused");
  EXPECT_GT(warnings[0].value, 40.0);
  const auto tracks_of = [](const Recording& one) {
    std::set<int> all;
    for (const Image& image : one.images)
      for (const TrackedPoint& point : image.tracks) all.insert(point.id);
    return all.size();
  };
  EXPECT_EQ(tracks_of(recording), tracks_of(strict) + static_cast<size_t>(warnings[0].value));
  EXPECT_LE(tracks_of(recording), tracks_of(whole));
  std::map<int, int> id_of;  // in the recording as it was, by that in the one that was split
  for (size_t k = 0; k < whole.images.size(); ++k) {
    const Image &before = whole.images[k], &now = recording.images[k];
    for (size_t i = 0; i < now.tracks.size(); ++i) id_of[now.tracks[i].id] = before.tracks[i].id;
    size_t others = 0;
    for (size_t i = 0; i < now.tracks1.size(); ++i)
      others += id_of.count(now.tracks1[i].id) == 0 || id_of[now.tracks1[i].id] != before.tracks1[i].id;
    EXPECT_LE(others, 3U) << k;
  }
}

// Those of which the simulator has made every fifth, far or near.
TEST(ImplausibleImages, ManyFalseMatchesAreLeftOutAndNamed) {
  RoomOptions options;
  options.simulation.calibration = ForwardStereo();
  const Recording whole = SimulateRoom(options);
  options.simulation.camera.outlier_fraction = 0.2;
  Recording recording = SimulateRoom(options);
  Recording strict = recording;
  EXPECT_THROW(CheckTracks(true, &strict), std::invalid_argument);
  const RecordingWarnings warnings = CheckTracks(false, &recording);
  ASSERT_EQ(Names(warnings), "false_matches");
  const auto points_of = [](const Recording& one) {
    size_t all = 0;
    for (const Image& image : one.images) all += image.tracks.size();
    return static_cast<double>(all);
  };
  EXPECT_EQ(points_of(recording), points_of(strict) - warnings[0].value);
  EXPECT_GT(warnings[0].value, 0.1 * points_of(strict));
  // What is left lies near the place of the same point without false matches.
  double far = 0.0;
  ASSERT_EQ(whole.images.size(), recording.images.size());
  for (size_t k = 0; k < whole.images.size(); ++k) {
    std::map<int, Vec2> places;
    for (const TrackedPoint& point : whole.images[k].tracks) places[point.id] = point.x;
    for (const TrackedPoint& point : recording.images[k].tracks)
      far += places.count(point.id) > 0 && (places[point.id] - point.x).norm() > 0.1;
  }
  EXPECT_LT(far, 0.01 * points_of(recording));
}

TEST(ImplausibleImages, ASecondCameraThatSeesNothingIsNamedAndDropped) {
  RoomOptions options;
  options.duration = 5.0;
  options.simulation.calibration = ForwardStereo();
  Recording recording = SimulateRoom(options);
  EXPECT_EQ(Names(CheckTracks(true, &recording)), "");
  EXPECT_TRUE(recording.calibration.camera1);
  for (size_t k = 0; k + 1 < recording.images.size(); ++k) recording.images[k].tracks1.clear();
  EXPECT_EQ(Names(CheckTracks(true, &recording)), "") << "it may miss images";
  recording.images.back().tracks1.clear();
  EXPECT_THROW(CheckTracks(true, &recording), std::invalid_argument);
  EXPECT_EQ(Names(CheckTracks(false, &recording)), "second_camera_unseen");
  EXPECT_FALSE(recording.calibration.camera1);
}

TEST(ImplausibleImages, ACameraWithoutNoiseMaySeeTheSameAtRest) {
  RoomOptions options;
  options.duration = 10.0;
  options.standstill_seconds = 2.0;
  options.simulation.camera.pixel_sigma = 0.0;
  Recording recording = SimulateRoom(options);
  const size_t images = recording.images.size();
  EXPECT_EQ(Names(CheckImages(true, &recording)), "");
  EXPECT_EQ(recording.images.size(), images);
}

}  // namespace
}  // namespace ch5
