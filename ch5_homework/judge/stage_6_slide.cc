/// Stage 6, TODOs 6i and 6j: the slide and the failures; at the end all of stage 6 together, slide after slide.

#include <gtest/gtest.h>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_homework/judge/narrate.h"
#include "ch5_homework/judge/seed.h"
#include "ch5_homework/judge/stage_6_window.h"

namespace ch5::homework {
namespace {

// ---- 6i SlideWindow --------------------------------------------------------------------------------------------------

// The positions before the slide, of all frames but one.
std::string Positions(const Window& window, size_t but) {
  std::string text;
  for (size_t k = 0; k < window.frames.size(); ++k) {
    if (k != but) text += (text.empty() ? "" : " ") + std::to_string(window.frames[k].id - kFirstId);
  }
  return text;
}
std::string Positions(const Window& window) { return Positions(window, window.frames.size()); }

void CheckFrames(const Window& before, const Window& after, size_t gone, const std::string& what) {
  const std::string right = Positions(before, gone), got = Positions(after);
  if (got == right) return;
  std::string cause = "another frame has left than the one that should";
  if (after.frames.size() == before.frames.size()) cause = "no frame has left: frames.erase(…)";
  if (after.frames.size() + 1 < before.frames.size()) cause = "more than one frame has left";
  if (got == Positions(before, before.frames.size() - 1)) {
    cause = "the newest frame has left; the second newest is frames.end() - 2";
  }
  if (got == Positions(before, 0)) cause = "the oldest frame has left, though the flag is kSecondNew";
  if (got == Positions(before, before.frames.size() - 2)) cause = "the second newest has left, though the flag is kOld";
  if (got == Positions(before, before.frames.size() - 3)) cause = "frames.end() - 3 is the third newest frame";
  if (got == Positions(before, 1)) cause = "frames.begin() + 1 is the second oldest frame";
  FAIL() << Story("6", "the frames after SlideWindow, " + what, right, got, cause, "6i");
}

// The landmark's depth in the camera of a frame.
double DepthSeenBy(const Window& window, const WindowLandmark& landmark, int frame) {
  const VertexPose& pose = *window.frames[static_cast<size_t>(window.IndexOf(frame))].pose;
  const Transform T_B_C = window.T_B_C();
  const Vec3 p_B = pose.q().conjugate() * (LandmarkInWorld(window, landmark) - pose.p());
  return (T_B_C.q.conjugate() * (p_B - T_B_C.p)).z();
}

// Every landmark, by whom it is seen, and its depth.
void CheckLandmarks(const Window& before, const Window& after, size_t gone, const std::string& what) {
  const int left = before.frames[gone].id;
  for (const auto& [track, landmark] : before.landmarks) {
    const std::string name = "landmark " + std::to_string(track) + " after SlideWindow, " + what;
    std::vector<int> right, got;
    for (const auto& seen : landmark.seen) {
      if (seen.frame != left) right.push_back(seen.frame - kFirstId);
    }
    const bool hosted = landmark.Host() == left;
    if (right.empty() || (hosted && landmark.inverse_depth && right.size() == 1)) right.clear();
    const auto found = after.landmarks.find(track);
    if (found != after.landmarks.end()) {
      for (const auto& seen : found->second.seen) got.push_back(seen.frame - kFirstId);
    }
    if (got != right) {
      const auto text = [](const std::vector<int>& frames) {
        return frames.empty() ? std::string("erased") : "seen by " + std::to_string(frames.size()) + " frames";
      };
      const bool still = std::count(got.begin(), got.end(), left - kFirstId) > 0;
      FAIL() << Story("6", name, text(right), text(got),
                      still         ? "an observation by the frame that has left is still there: ForgetObservations"
                      : got.empty() ? "it is thrown away, though other frames see it: it needs another host"
                                    : "other observations were lost than those of the frame that leaves",
                      "6i");
    }
    if (got.empty() || !landmark.inverse_depth) continue;
    const double depth = DepthSeenBy(before, landmark, found->second.Host());
    const double got_depth = 1.0 / found->second.inverse_depth->InverseDepth();
    if (std::abs(got_depth - depth) < 1e-9 * depth) continue;
    FAIL() << Story("6", "the depth of " + name, Number(depth) + " m", Number(got_depth) + " m",
                    "a depth stands in its host's camera: a new host needs a new one, which ForgetObservations "
                    "computes while both frames are there",
                    "6i");
  }
}

struct ImuPiece {
  double seconds = 0.0;
  Vec3 alpha = Vec3::Zero();
  bool Is(const ImuPiece& other) const {
    return std::abs(seconds - other.seconds) < 1e-9 && (alpha - other.alpha).norm() < 1e-9;
  }
};
ImuPiece Piece(const std::shared_ptr<Preintegration>& imu) {
  return imu ? ImuPiece{imu->SumDt(), imu->Alpha()} : ImuPiece{};
}
ImuPiece Merged(Preintegration first, const Preintegration& second) {
  first.Append(second);
  return {first.SumDt(), first.Alpha()};
}

void CheckImu(const Window& before, const Window& after, size_t gone, const std::string& what) {
  const auto own = [&](size_t k) { return before.frames[k].imu; };
  for (size_t k = 0; k < after.frames.size(); ++k) {
    const size_t old = k < gone ? k : k + 1;
    ImuPiece right = Piece(own(old));
    if (k == 0) right = {};
    if (gone > 0 && old == gone + 1) right = Merged(*own(gone), *own(old));
    const ImuPiece got = Piece(after.frames[k].imu);
    if (got.Is(right)) continue;
    std::string cause = "the IMU of a frame that has nothing to do with it has changed";
    if (k == 0) {
      cause = "the first frame has none before it: its imu must be null";
    } else if (gone > 0 && old == gone + 1) {
      cause = "the newest frame's IMU must be that of the frame that leaves, followed by its own";
      if (got.Is({})) cause = "the IMU between the two frames is gone";
      if (got.Is(Piece(own(old)))) cause = "the samples of the frame that leaves are lost: they come before its own";
      if (got.Is(Piece(own(gone)))) cause = "the newest frame's own samples are lost: they follow";
      if (got.Is(Merged(*own(old), *own(gone)))) cause = "the two pieces are in the wrong order: the older one first";
    } else if (gone == 0 && k == 1 && std::abs(got.seconds - right.seconds) > 1e-9) {
      cause = "MARGIN_OLD merges nothing: the piece between frames 0 and 1 is in the prior";
    }
    FAIL() << Story("6", "the IMU before frame " + std::to_string(k) + " after SlideWindow, " + what,
                    Number(right.seconds) + " s", Number(got.seconds) + " s", cause, "6i");
  }
}

void CheckSlide(MarginalizationFlag flag, const std::string& what) {
  const Window before = FullWindow();
  Window after = FullWindow();  // alike, but nothing is shared
  const size_t gone = flag == MarginalizationFlag::kOld ? 0 : before.frames.size() - 2;
  Chosen().vins_window.slide(flag, &after);
  CheckFrames(before, after, gone, what);
  if (!testing::Test::HasFatalFailure()) CheckLandmarks(before, after, gone, what);
  if (!testing::Test::HasFatalFailure()) CheckImu(before, after, gone, what);
}

TEST(Stage6, SlidesTheOldestFrameOut) { CheckSlide(MarginalizationFlag::kOld, "flag kOld"); }
TEST(Stage6, SlidesTheSecondNewestFrameOut) { CheckSlide(MarginalizationFlag::kSecondNew, "flag kSecondNew"); }

// ---- 6j DetectFailure ------------------------------------------------------------------------------------------------

// As it stands in the code.
std::string NameOf(Failure failure) {
  static const std::map<Failure, std::string> names{{Failure::kNone, "kNone"},
                                                    {Failure::kAccelerometerBias, "kAccelerometerBias"},
                                                    {Failure::kGyroscopeBias, "kGyroscopeBias"},
                                                    {Failure::kPositionJump, "kPositionJump"},
                                                    {Failure::kHeightJump, "kHeightJump"}};
  const auto it = names.find(failure);
  return it == names.end() ? "another one" : it->second;
}

struct FailureCase {
  std::string what;
  double b_a, b_g;
  Vec3 step;
  Failure right;
  std::string cause;
};

// The values in three unlike components, each below the threshold that the norm is held against; at the threshold itself
// in one, for the norm to be exact.
Vec3 OfNorm(double norm) { return norm == 2.5 || norm == 1.0 ? Vec3(0, 0, -norm) : norm * Vec3(2, -2, 1) / 3.0; }

std::vector<FailureCase> FailureCases() {
  const Vec3 small(0.3, 0.1, 0.1);
  const Failure none = Failure::kNone;
  return {
      {"nothing unusual; the speed is 8 m/s", 0.1, 0.01, small, none,
       "a comparison is the wrong way round, or the speed, or the oldest frame, is taken for a bias"},
      {"b_a of 2.51 m/s²", 2.51, 0.01, small, Failure::kAccelerometerBias,
       "‖b_a‖ > 2.5 is a failure: its norm, of the newest frame, whatever is tracked"},
      {"b_a of 2.49 m/s²", 2.49, 0.01, small, none, "the accelerometer's limit is 2.5 m/s²: of the norm, not squared"},
      {"b_g of 1.01 rad/s", 0.1, 1.01, small, Failure::kGyroscopeBias,
       "‖b_g‖ > 1 is a failure: rad/s, its norm, of the newest frame, whatever is tracked"},
      {"b_g of 0.99 rad/s, which is 57 degrees per second", 0.1, 0.99, small, none,
       "the gyroscope's limit is 1 rad/s: no degrees"},
      {"a step of 5.01 m, level", 0.1, 0.01, 5.01 * Vec3(-0.6, 0.8, 0), Failure::kPositionJump,
       "a step of more than 5 m is a failure: ‖p − last_p‖ of the newest frame"},
      {"a step of 4.96 m level and 0.9 m upwards", 0.1, 0.01, Vec3(-2.976, 3.968, 0.9), Failure::kPositionJump,
       "the length of a step counts its height too: ‖p − last_p‖ of all three"},
      {"a step of 4.99 m, level", 0.1, 0.01, 4.99 * Vec3(0.6, 0.8, 0), none,
       "the limit of a step is 5 m: of its norm, not squared; 1 m is that of the height"},
      {"a step of 1.01 m upwards", 0.1, 0.01, Vec3(0, 0, 1.01), Failure::kHeightJump,
       "more than 1 m in height is a failure"},
      {"a step of 1.01 m downwards", 0.1, 0.01, Vec3(0, 0, -1.01), Failure::kHeightJump,
       "downwards counts as much as upwards: std::abs"},
      {"a step of 0.99 m upwards", 0.1, 0.01, Vec3(0, 0, 0.99), none, "the limit of the height is 1 m"},
      {"b_a of 2.5 m/s², b_g of 1 rad/s, a step of 5 m, level", 2.5, 1.0, Vec3(3, -4, 0), none,
       "a value at its limit is no failure: >, not >="},
      {"a step of 1 m downwards", 0.1, 0.01, Vec3(0, 0, -1), none, "a value at its limit is no failure: >, not >="},
  };
}

TEST(Stage6, FailuresAtTheirThresholds) {
  for (const FailureCase& c : FailureCases()) {
    for (const bool tracks : {true, false}) {
      Window window = tracks ? FullWindow() : Frames(11);
      const WindowFrame &newest = window.frames.back(), &oldest = window.frames.front();
      Vec9 v_ba_bg;
      v_ba_bg << 8.0, 0.0, 0.0, OfNorm(c.b_a), OfNorm(c.b_g);
      newest.speed_bias->SetEstimate(v_ba_bg);
      v_ba_bg << Vec3::Zero(), Vec3(9, 0, 0), Vec3(9, 0, 0);
      oldest.speed_bias->SetEstimate(v_ba_bg);
      const Vec3 p = (8.0 * newest.pose->p()).array().round() / 8.0;  // of few digits, so that steps are exact
      newest.pose->SetPose(ExpSO3(Vec3(0, 0, 1.5)), p);               // a fast turn is no failure
      const Vec3 last_p = p - c.step;
      const Failure got = Chosen().vins_window.detect_failure(window, last_p);
      if (got == c.right) continue;
      FAIL() << Story("6", "DetectFailure: " + c.what + (tracks ? "" : ", no tracks"), NameOf(c.right), NameOf(got),
                      c.cause, "6j");
    }
  }
}

// ---- all of it -------------------------------------------------------------------------------------------------------

std::shared_ptr<EdgePrior> MarginalizeByTheHomework(const DropSet& drop) {
  const auto term = Chosen().make_vins_term();
  for (const auto& edge : drop.edges) {
    ResidualBlockInfo info{edge, {}};
    for (size_t i = 0; i < edge->Vertices().size(); ++i) {
      if (Holds(drop.vertices, edge->Vertices()[i])) info.drop_set.push_back(static_cast<int>(i));
    }
    term->AddResidualBlockInfo(info);
  }
  term->PreMarginalize();
  term->ConstructA();
  term->Factor(term->SchurComplement());
  return std::make_shared<EdgePrior>(term->GetParameterBlocks({}));
}

TEST(Stage6, TheWindowSlidesAgainAndAgain) {
  Window window = Frames(6);
  See(1, Vec3(1, 1, 6), 0, 4, &window);
  See(2, Vec3(0, -1, 7), 1, 5, &window);
  window.prior = PriorOn({window.frames[0].pose, window.frames[0].speed_bias});
  Random random(Seed(68));
  int track = 10;
  using Flag = MarginalizationFlag;
  for (const Flag flag : {Flag::kOld, Flag::kOld, Flag::kSecondNew, Flag::kOld, Flag::kSecondNew, Flag::kOld}) {
    See(++track, Vec3{random.Uniform(0, 3), random.Uniform(-1, 1), 6.0}, 1, 5, &window);  // {}: from left to right
    TriangulateLandmarks(&window);
    BuildGraph({}, UseAll, &window);
    DropSet right = RightMarginOld(window);
    if (flag == Flag::kSecondNew) {
      const auto& pose = window.frames[4].pose;
      right = Holds(window.prior->Vertices(), pose) ? DropSet{{window.prior}, {pose}} : DropSet{};
    }
    const auto& functions = Chosen().vins_window;
    const DropSet drop = flag == Flag::kOld ? functions.margin_old(window) : functions.margin_second_new(window);
    ASSERT_TRUE(Same(drop, right)) << "Stage 6: the drop set in a window that has slid: " << Inventory(drop);
    if (!drop.edges.empty()) {
      const MarginalSystem system = EliminateVertices(right.edges, right.vertices);
      window.prior = MarginalizeByTheHomework(drop);
      const Prior& prior = window.prior->GetPrior();
      ASSERT_EQ(prior.vertices, system.kept) << "Stage 6: the prior stands on other vertices than those kept";
      ASSERT_NO_STORY(
          {"6", "JᵀJ of the prior of a window that slides", system.H, prior.J.transpose() * prior.J, {}, {}, 1e-6});
      ASSERT_NO_STORY(
          {"6", "−Jᵀr₀ of the prior of a window that slides", system.b, -prior.J.transpose() * prior.r0, {}, {}, 1e-6});
    }
    functions.slide(flag, &window);
    ASSERT_EQ(window.frames.size(), 5u) << "Stage 6: the window does not keep its size";
    for (const auto& [id, landmark] : window.landmarks) {
      for (const auto& seen : landmark.seen) {
        ASSERT_GE(window.IndexOf(seen.frame), 0) << "Stage 6: a frame that has left still sees landmark " << id;
      }
    }
    AddFrame(&window);
  }
}

}  // namespace
}  // namespace ch5::homework
