/// The rules of the two policies, one by one; those of the graded functions: ch5_homework/judge/stage_6*.cc.
#include <gtest/gtest.h>

#include "ch5_backend/window/image_overlap.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/policy.h"
#include "ch5_backend/window/vins_window.h"
#include "tests/window/straight.h"

namespace ch5 {
namespace {

TEST(Landmark, TriangulatesToTheTrueDepth) {
  Window window = Straight(4);
  See(1, Vec3(1, 2, 8), 0, 3, &window);
  See(2, Vec3(1, 2, -8), 0, 3, &window);  // behind the cameras, as an outlier may claim
  EXPECT_NEAR(TriangulateDepth(window, window.landmarks[1]), 8.0, 1e-9);
  EXPECT_EQ(TriangulateDepth(window, window.landmarks[2]), kInitialDepth);
}

TEST(Landmark, KeepsItsPlaceWhenItsHostLeaves) {
  Window window = Straight(4);
  See(1, Vec3(1, 2, 8), 0, 3, &window);
  See(2, Vec3(0, 1, 5), 0, 1, &window);
  TriangulateLandmarks(&window);
  const Vec3 before = LandmarkInWorld(window, window.landmarks[1]);
  ForgetObservations(window.frames[0].id, DepthInCamera, &window);
  EXPECT_EQ(window.landmarks[1].Host(), window.frames[1].id);
  EXPECT_LT((LandmarkInWorld(window, window.landmarks[1]) - before).norm(), 1e-9);
  EXPECT_EQ(window.landmarks.count(2), 0u) << "one observation holds no depth";
}

TEST(Landmark, WithANegativeDepthIsAFailure) {
  Window window = Straight(2);
  See(1, Vec3(0, 0, 5), 0, 1, &window);
  See(2, Vec3(0, 1, 5), 0, 1, &window);
  TriangulateLandmarks(&window);
  window.landmarks[1].inverse_depth->SetEstimate(VertexInverseDepth::Estimate(-0.2));
  RemoveFailures(&window);
  EXPECT_EQ(window.landmarks.count(1), 0u);
  EXPECT_EQ(window.landmarks.count(2), 1u);
}

TEST(Graph, KeepsTheEdgesOfObservationsThatAreTheSame) {
  Window window = Straight(4);
  See(1, Vec3(1, 2, 8), 0, 3, &window);
  See(2, Vec3(0, 1, 5), 1, 3, &window);
  TriangulateLandmarks(&window);
  WindowWeights weights;
  const auto edges_of = [&](int track) {
    BuildGraph(weights, UseAll, &window);
    return EdgesAt(window.graph, {window.landmarks[track].inverse_depth});
  };
  const auto first = edges_of(1), second = edges_of(2);
  ASSERT_EQ(first.size(), 3u);
  EXPECT_EQ(edges_of(1), first);
  ForgetObservations(window.frames[0].id, DepthInCamera, &window);
  const auto moved = edges_of(1);
  ASSERT_EQ(moved.size(), 2u) << "with another host";
  for (const auto& edge : moved) EXPECT_EQ(std::count(first.begin(), first.end(), edge), 0);
  EXPECT_EQ(edges_of(2), second);
  weights.pixel_sigma *= 2.0;
  for (const auto& edge : edges_of(2)) {
    EXPECT_EQ(std::count(second.begin(), second.end(), edge), 0) << "with another weight";
    EXPECT_DOUBLE_EQ(edge->IsotropicInformation(), second[0]->IsotropicInformation() / 4.0);
  }
  window.extrinsic->SetFixed(false);
  for (const auto& edge : edges_of(2)) EXPECT_EQ(edge->TypeInfo(), "EdgeReprojectionCalibration");
}

TEST(Graph, KeepsAnImuEdgeWhileItsPreintegrationIsTheSame) {
  Window window = Straight(3);
  const auto edges = [&] {
    BuildGraph({}, UseAll, &window);
    return window.graph.Edges();
  };
  const auto first = edges();
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(edges(), first);
  Preintegration& imu = *window.frames[1].imu;
  imu.Reintegrate(Vec3::Zero(), Vec3(0.1, 0, 0));
  const auto reintegrated = edges();
  EXPECT_NE(reintegrated[0], first[0]);
  EXPECT_EQ(reintegrated[1], first[1]);
  imu.Add({0.1, Vec3(0, 0, 9.81), Vec3::Zero()});
  const auto longer = edges();
  EXPECT_NE(longer[0], reintegrated[0]);
  EXPECT_NE(longer[0]->Information(), reintegrated[0]->Information());
  window.frames[2].imu = std::make_shared<Preintegration>(imu);
  const auto other = edges();
  window.frames.erase(window.frames.begin() + 1);
  EXPECT_EQ(edges().size(), 1u);
  EXPECT_NE(edges()[0], other[1]) << "from another frame";
}

TEST(Vins, UsesLandmarksHostedBeforeTheLastThreeFrames) {
  Window window = Straight(11);
  const auto policy = MakeVinsPolicy();
  const auto take_images_every = [&](double seconds) {
    for (size_t k = 0; k < window.frames.size(); ++k) window.frames[k].t = seconds * static_cast<double>(k);
  };
  take_images_every(0.1);
  See(7, Vec3(0, 0, 9), 7, 10, &window);
  See(8, Vec3(0, 0, 9), 8, 10, &window);
  See(1, Vec3(0, 0, 9), 1, 1, &window);
  EXPECT_TRUE(policy->Uses(window, window.landmarks[7]));
  EXPECT_FALSE(policy->Uses(window, window.landmarks[8]));
  EXPECT_FALSE(policy->Uses(window, window.landmarks[1])) << "seen once";
  take_images_every(0.4);
  EXPECT_TRUE(policy->Uses(window, window.landmarks[8])) << "at 2.5 Hz";
}

TEST(Vins, RestoresPositionAndYawOfTheOldestFrame) {
  Window window = Straight(4);
  const auto policy = MakeVinsPolicy();
  const Qd upright = ExpSO3(Vec3(0, -M_PI / 2, 0));  // pitch −90°, where yaw angles are not defined
  window.frames[0].pose->SetPose(upright, Vec3(1, 2, 3));
  policy->NoteNewFrame(&window);
  const Qd relative = window.frames[0].pose->q().conjugate() * window.frames[3].pose->q();
  const Qd turn = ExpSO3(Vec3(0, 0, 0.7));
  for (const Frame& frame : window.frames) {
    frame.pose->SetPose(turn * frame.pose->q(), turn * frame.pose->p() + Vec3(5, 5, 5));
  }
  policy->AfterSolve(&window);
  EXPECT_LT((window.frames[0].pose->p() - Vec3(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT(window.frames[0].pose->q().angularDistance(upright), 1e-7);
  EXPECT_LT((window.frames[0].pose->q().conjugate() * window.frames[3].pose->q()).angularDistance(relative), 1e-7);
}

TEST(Window, LeavesOutImuIntervalsOverTenSeconds) {
  Window window = Straight(2);
  for (const double seconds : {9.4, 9.6}) {  // 0.5 s are there already
    const ImuSample sample{seconds, Vec3(0, 0, 9.81), Vec3::Zero()};
    auto imu = std::make_shared<Preintegration>(*window.frames[1].imu);
    imu->Add(sample);
    Window longer = Straight(2);
    longer.frames[1].imu = imu;
    BuildGraph({}, UseAll, &longer);
    EXPECT_EQ(longer.graph.Edges().size(), seconds < 9.5 ? 1u : 0u);
  }
}

// By hand: the unit square with a point inside; without its corner (1, 1), a triangle of half the area.
TEST(Okvis, HullAreasAndOverlap) {
  EXPECT_NEAR(HullArea({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}}), 1.0, 1e-15);
  EXPECT_EQ(HullArea({{0, 0}, {1, 1}}), 0.0);
  Window window = Straight(2);
  int track = 0;
  for (const Vec3& p : {Vec3(1, 0, 1), Vec3(2, 0, 1), Vec3(1, 1, 1)}) See(track++, p, 0, 1, &window);
  See(track++, Vec3(2, 1, 1), 1, 1, &window);
  const ImageOverlap overlap = ImageOverlapOf(window, window.frames[0].id, window.frames[1].id);
  EXPECT_NEAR(overlap.hull_ratio, 0.5, 1e-12);
  EXPECT_NEAR(overlap.match_ratio, 0.75, 1e-12);
}

// Both images see the same points: of the overlap alone, the second would never be a keyframe.
TEST(Okvis, AnImageThatSeesThePointsFromElsewhereIsAKeyframe) {
  for (const double distance : {2.0, 4.0}) {  // of points seen from places 1 m apart: 27° and 14°
    Window window = Straight(2);
    int track = 0;
    for (const Vec3& p : {Vec3(0, 0, distance), Vec3(0, 0.1, distance), Vec3(0.1, 0, distance)})
      See(track++, p, 0, 1, &window);
    const ImageOverlap overlap = ImageOverlapOf(window, window.frames[0].id, window.frames[1].id);
    EXPECT_NEAR(overlap.angle, std::atan(1.0 / distance), 0.01);
    EXPECT_EQ(overlap.hull_ratio, 1.0);
    MakeOkvisPolicy()->NoteNewFrame(&window);
    EXPECT_EQ(window.frames[1].is_keyframe, distance == 2.0);
  }
}

}  // namespace
}  // namespace ch5
