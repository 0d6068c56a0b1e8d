/// OKVIS's published behavior, row by row, and the file that tests it:
///
///   OK1, OK2, OK4 – OK6, OK8, OK10         ../marginalize/marginalization_error_test.cc
///   OK3  relative eigenvalue cutoff        here
///   OK7  loss correction                   ../graph/loss_test.cc
///   OK9  sign of a quaternion              ../types/edge_imu_test.cc
///   OK11 the gauge prior                   here, ../consistency/gauge_audit_test.cc
///   OK12 Dogleg                            here
///   OK13 what leaves; 10 s at 1 m/s        here
///   OK14 keyframes                         here
///   OK15 a wrong initial depth             here
#include <gtest/gtest.h>

#include "ch5_backend/marginalize/square_root.h"
#include "ch5_backend/simulate/sensors/scene_points.h"
#include "ch5_backend/simulate/sensors/simulation.h"
#include "ch5_backend/sparse/sparse_optimizer.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/policy.h"
#include "ch5_backend/window/prediction.h"
#include "tests/window/straight.h"

namespace ch5 {
namespace {

// Two directions that all but coincide, the smaller eigenvalue being `ratio`/4 of the larger.
MatXX NearlySingular(double unit, double ratio) { return unit * (Mat22() << 1.0, 1.0, 1.0, 1.0 + ratio).finished(); }

// At one ratio of eigenvalues OKVIS decides the same whatever the unit; VINS's absolute 1e-8 does not.
TEST(OkvisRow3, EigenvaluesAreCutRelativeToTheLargest) {
  const auto rank = [](const MatXX& H, const EigenvalueCutoff& cut) {
    return FactorNormalEquations(H, VecX::Zero(2), cut).J.rows();
  };
  for (const double unit : {1e-6, 1.0, 1e6}) {
    EXPECT_EQ(rank(NearlySingular(unit, 1e-6), EigenvalueCutoff::Okvis()), 2) << unit;
    EXPECT_EQ(rank(NearlySingular(unit, 1e-16), EigenvalueCutoff::Okvis()), 1) << unit;
  }
  EXPECT_EQ(rank(NearlySingular(1.0, 1e-6), EigenvalueCutoff::Vins()), 2);
  EXPECT_EQ(rank(NearlySingular(1e-3, 1e-6), EigenvalueCutoff::Vins()), 1);
}

// Information on the directions x, y, z, yaw, pitch, roll of a level frame.
Vec6 HeldInformation(const Window& window) {
  const auto& prior = dynamic_cast<const EdgePrior&>(*window.gauge_prior).GetPrior();
  const Mat66 H = prior.J.transpose() * prior.J;
  Vec6 held;
  held << H(0, 0), H(1, 1), H(2, 2), H(5, 5), H(4, 4), H(3, 3);
  return held;
}

TEST(OkvisRow11, HoldsPositionAndYawOfTheFirstFrameAndLaterOfTheOldest) {
  Window window = Straight(9);
  OkvisOptions options;
  const auto policy = MakeOkvisPolicy(options);
  policy->NoteNewFrame(&window);
  const auto expect = [&](int frame, double information) {
    EXPECT_EQ(window.gauge_prior->Vertices()[0], window.frames[static_cast<size_t>(window.IndexOf(frame))].pose);
    const Vec6 held = HeldInformation(window);
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(held[k] / information, 1.0, 1e-12) << k;
    EXPECT_EQ(held[4], 0.0);
    EXPECT_EQ(held[5], 0.0);
  };
  expect(window.frames[0].id, 1e8);
  BuildGraph({}, UseAll, &window);
  policy->Slide(&window);  // six frames are no longer among the three newest, five of them stay as keyframes
  ASSERT_EQ(window.frames.size(), 8u);
  expect(window.frames[0].id, 1e14);
}

TEST(OkvisRow12, IteratesByDogleg) { EXPECT_EQ(MakeOkvisPolicy()->Options().algorithm, Algorithm::kDogleg); }

// Nine frames: 0 … 5 walked, of which 1 and 4 are keyframes, with K = 1, S = 3.
Window Walked() {
  Window window = Straight(9);
  for (int k = 0; k < 9; ++k) window.frames[static_cast<size_t>(k)].is_keyframe = k == 1 || k == 4;
  return window;
}

std::unique_ptr<WindowPolicy> OneKeyframe() {
  OkvisOptions options;
  options.keyframes = 1;
  return MakeOkvisPolicy(options);
}

TEST(OkvisRow13, NonKeyframesAndOldKeyframesLoseTheirPosesAndAllWalkedTheirSpeeds) {
  Window window = Walked();
  const int keyframe = window.frames[4].id, newest = window.frames[6].id;
  BuildGraph({}, UseAll, &window);
  OneKeyframe()->Slide(&window);
  ASSERT_EQ(window.frames.size(), 4u);
  EXPECT_EQ(window.frames[0].id, keyframe);
  EXPECT_EQ(window.frames[1].id, newest);
  EXPECT_FALSE(window.frames[0].speed_bias);
  for (size_t k = 1; k < 4; ++k) EXPECT_TRUE(window.frames[k].speed_bias);
}

// c is frame 5, the newest walked one.  OK15: two observations count, not two frames that leave.
TEST(OkvisRow13, LandmarksSeenSinceTheNewestWalkedFrameStay) {
  Window window = Walked();
  See(1, Vec3(0, 0, 9), 0, 6, &window);  // seen since c: stays, without its observations in the frames that leave
  See(2, Vec3(0, 1, 9), 0, 4, &window);  // not seen since: marginalized, with its observation in the keyframe
  See(3, Vec3(0, 2, 9), 0, 0, &window);  // seen once: dropped
  See(4, Vec3(0, 3, 9), 6, 8, &window);  // touches no frame that leaves
  See(5, Vec3(0, 4, 9), 4, 4, &window);  // in the keyframe only: likewise
  TriangulateLandmarks(&window);
  const auto keyframe = window.frames[4].pose;
  BuildGraph({}, UseAll, &window);
  OneKeyframe()->Slide(&window);
  ASSERT_EQ(window.landmarks.count(1), 1u);
  EXPECT_EQ(window.landmarks[1].seen.size(), 2u);
  EXPECT_EQ(window.landmarks.count(2), 0u);
  EXPECT_EQ(window.landmarks.count(3), 0u);
  EXPECT_EQ(window.landmarks.count(4), 1u);
  EXPECT_EQ(window.landmarks.count(5), 1u);
  // OK15: the new term ties what remains, here the keyframe by landmark 2 and frame 6 by the IMU.
  ASSERT_TRUE(window.prior);
  const auto& held = window.prior->GetPrior().vertices;
  const std::vector<std::shared_ptr<Vertex>> expected = {keyframe, window.frames[1].pose, window.frames[1].speed_bias};
  EXPECT_EQ(held, expected);
}

TEST(OkvisRow14, AKeyframeUnlessBothOverlapAndMatchesAreGreat) {
  // A new image with 100 points on a line of length 1 and a base point off it; of the line the older image saw a share.
  const auto is_keyframe = [](double hull, int matches) {
    Window window = Straight(2);
    int track = 0;
    const auto see = [&](const Vec2& x, bool before) {
      auto& seen = window.landmarks[track++].seen;
      if (before) seen.push_back({window.frames[0].id, x, Vec2::Zero()});
      seen.push_back({window.frames[1].id, x, Vec2::Zero()});
    };
    see(Vec2(0, 1), true);
    see(Vec2(0, 0), true);
    see(Vec2(hull, 0), true);
    see(Vec2(1, 0), false);
    for (int k = 4; k < 100; ++k) see(Vec2(0.001 * k, 0), k - 1 < matches);
    const auto policy = MakeOkvisPolicy();
    policy->NoteNewFrame(&window);
    return window.frames[1].is_keyframe;
  };
  EXPECT_FALSE(is_keyframe(0.61, 21));
  EXPECT_TRUE(is_keyframe(0.59, 21)) << "too little overlap";
  EXPECT_TRUE(is_keyframe(0.61, 20)) << "too few matches";
}

// ---- OKVIS's own test of its estimator: 10 s at 1 m/s, seven images, keyframe each third, strategy (2, 3) -------------
// Its two cameras measure depth. One camera at constant speed cannot tell scale, so here the start knows the speed.

class Drive {
 public:
  Drive(const Transform& T_B_C, bool estimate_extrinsic) {
    Random random(3);
    SimulationOptions options;
    options.calibration.T_B_C = T_B_C;
    options.calibration.camera_rate = 0.6;
    options.calibration.noise = {2e-3, 6e-4, 2e-5, 3e-6, /*continuous=*/true};
    options.imu.b_a = options.imu.b_g = Vec3::Zero();
    const auto ahead = [](const Jet& t) { return Coordinates{{t, 0.0, 0.0}, 0.0, 0.0, 0.0}; };
    const PlanePatch wall{Vec3(-10, -6, 6), Vec3(30, 0, 0), Vec3(0, 12, 0)};
    const PlanePatch nearer{Vec3(-10, -6, 4), Vec3(30, 0, 0), Vec3(0, 12, 0)};
    recording_ = SimulateRecording(Trajectory(ahead, 10.0), PointsOnPlanes({wall, nearer}, 400, &random), options);
    window_.extrinsic->SetPose(T_B_C.q, T_B_C.p);
    window_.extrinsic->SetFixed(!estimate_extrinsic);
    window_.time_offset->SetFixed();
  }

  void Run() {
    OkvisOptions options;
    options.keyframes = 2;
    const auto policy = MakeOkvisPolicy(options);
    SparseOptimizer optimizer(&window_.graph);
    optimizer.SetDamping(Damping::kDiagonal);
    ASSERT_EQ(recording_.images.size(), 7u);
    for (int k = 0; k < 7; ++k) {
      Append(recording_.images[static_cast<size_t>(k)], k);
      policy->NoteNewFrame(&window_);
      window_.frames.back().is_keyframe = k % 3 == 0;
      TriangulateLandmarks(&window_);
      BuildGraph(
          {}, [&](const Window& w, const WindowLandmark& l) { return policy->Uses(w, l); }, &window_);
      optimizer.Solve(policy->Options());
      last_ = window_.StateOf(window_.frames.back());
      policy->Slide(&window_);
    }
  }

  void ExpectTheTruth() const {
    const StampedState truth = *StateAt(recording_.truth, last_.t);
    EXPECT_LT((last_.v_W - truth.v_W).norm(), 0.04);
    EXPECT_LT((last_.b_a - truth.b_a).norm(), 0.04);
    EXPECT_LT((last_.b_g - truth.b_g).norm(), 0.04);
    EXPECT_LT(last_.T_W_B.q.angularDistance(truth.T_W_B.q), 1e-2);
    EXPECT_LT((last_.T_W_B.p - truth.T_W_B.p).norm(), 0.1);
    EXPECT_EQ(window_.frames.size(), 5u);
  }

 private:
  // The IMU predicts the new frame; the first one is known, its biases up to the calibration.
  void Append(const Image& image, int id) {
    Frame frame;
    frame.id = id;
    frame.t = image.t;
    StampedState state;
    state.v_W = Vec3::UnitX();
    if (id > 0) {
      const StampedState last = window_.StateOf(window_.frames.back());
      frame.imu = IntegrateFrom(last, recording_.imu, frame.t, recording_.calibration.noise);
      state = Predict(last, *frame.imu, 9.81);
    }
    frame.pose = std::make_shared<VertexPose>(state.T_W_B.q, state.T_W_B.p);
    frame.speed_bias = std::make_shared<VertexSpeedBias>((Vec9() << state.v_W, state.b_a, state.b_g).finished());
    if (id == 0) window_.prior = StartPrior(frame.speed_bias);
    window_.frames.push_back(frame);
    for (const TrackedPoint& point : image.tracks) AppendToTrack({id, image.t, point.x}, &window_.landmarks[point.id]);
  }

  std::shared_ptr<EdgePrior> StartPrior(const std::shared_ptr<VertexSpeedBias>& speed_bias) const {
    Eigen::Matrix<double, 15, 1> sigma;  // speed 5 mm/s; biases 0.01 m/s² and 0.001 rad/s; camera 1 cm and 0.01 rad
    sigma << Vec3::Constant(0.005), Vec3::Constant(0.01), Vec3::Constant(0.001), Vec6::Constant(0.01);
    const bool free = !window_.extrinsic->IsFixed();
    Prior prior;
    prior.vertices = {speed_bias};
    prior.x0 = {speed_bias->GetEstimate()};
    if (free) {
      prior.vertices.push_back(window_.extrinsic);
      prior.x0.push_back(window_.extrinsic->GetEstimate());
    }
    prior.J = sigma.head(free ? 15 : 9).cwiseInverse().asDiagonal();
    prior.r0 = VecX::Zero(prior.J.rows());
    return std::make_shared<EdgePrior>(prior);
  }

  Recording recording_;
  Window window_;
  StampedState last_;
};

TEST(OkvisRow13, TenSecondsAtOneMeterPerSecond) {
  const Transform at_the_body, aside{ExpSO3(Vec3(0.05, -0.1, 0.3)), Vec3(0.1, -0.05, 0.02)};
  for (const Transform& T_B_C : {at_the_body, aside}) {
    for (const bool estimate_extrinsic : {false, true}) {
      SCOPED_TRACE("camera at " + std::to_string(T_B_C.p.x()) + (estimate_extrinsic ? ", estimated" : ", fixed"));
      Drive drive(T_B_C, estimate_extrinsic);
      drive.Run();
      drive.ExpectTheTruth();
    }
  }
}

}  // namespace
}  // namespace ch5
