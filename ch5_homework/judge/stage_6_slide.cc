/// Stage 6, TODOs 6i and 6j: the slide and the failures; at the end all of stage 6 together, slide after slide.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "ch5_backend/marginalize/marginalize.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/stage_6_window.h"

namespace ch5::homework {
namespace {

struct ImuInterval {
  double seconds = 0.0;
  Vec3 alpha = Vec3::Zero();
  bool Is(const ImuInterval& other) const {
    return std::abs(seconds - other.seconds) < 1e-9 && (alpha - other.alpha).norm() < 1e-9;
  }
};
ImuInterval IntervalOf(const std::shared_ptr<Preintegration>& imu) {
  return imu ? ImuInterval{imu->SumDt(), imu->Alpha()} : ImuInterval{};
}
ImuInterval Merged(Preintegration first, const Preintegration& second) {
  first.Append(second);
  return {first.SumDt(), first.Alpha()};
}

// A window that the submission has slid.
struct Slid {
  std::vector<int> frames;               // ids
  std::vector<bool> has_imu;             // of each frame
  std::vector<ImuInterval> imu;          // likewise
  std::map<int, std::vector<int>> seen;  // by track, the frames
  std::map<int, double> inverse_depths;  // likewise, of those that have one

  explicit Slid(const Answer& answer, const std::string& number = "") {
    const auto table = [&](const char* name, Eigen::Index rows) {
      return answer.Sized(name + number, rows, answer[name + number].cols());
    };
    const MatXX all = table("frames", 6), pairs = table("seen", 2), depths = table("depths", 2);
    for (Eigen::Index k = 0; k < all.cols(); ++k) {
      frames.push_back(Whole(all(0, k)));
      has_imu.push_back(all(1, k) != 0.0);
      imu.push_back({all(2, k), all.col(k).tail<3>()});
    }
    for (Eigen::Index k = 0; k < pairs.cols(); ++k) seen[Whole(pairs(0, k))].push_back(Whole(pairs(1, k)));
    for (Eigen::Index k = 0; k < depths.cols(); ++k) inverse_depths[Whole(depths(0, k))] = depths(1, k);
  }
};

// ---- 6i SlideWindow --------------------------------------------------------------------------------------------------

std::vector<int> IdsOf(const Window& window) {
  std::vector<int> ids;
  for (const Frame& frame : window.frames) ids.push_back(frame.id);
  return ids;
}
// Of all frames but one, their positions before the slide.
std::string Positions(const std::vector<int>& ids, size_t but) {
  std::string text;
  for (size_t k = 0; k < ids.size(); ++k) {
    if (k != but) text += (text.empty() ? "" : " ") + std::to_string(ids[k] - kFirstId);
  }
  return text;
}

// "the frames after SlideWindow, flag kOld"
Text AfterSlide(const Text& what, const char* flag) {
  return {"6.after_slide", {{"what", what}, {"flag", Word(flag)}}};
}

void CheckFrames(const Window& window, const Slid& after, size_t gone, const char* flag) {
  const std::vector<int> before = IdsOf(window);
  const std::string right = Positions(before, gone), got = Positions(after.frames, after.frames.size());
  if (got == right) return;
  const size_t n = before.size();
  Text cause = after.frames.size() == n      ? "6.no_frame_left"
               : after.frames.size() + 1 < n ? "6.more_one_frame_left"
                                             : "6.another_frame_left";
  for (const auto& [left, that] : {std::pair{n - 1, "6.newest_frame_left"},
                                   {0, "6.oldest_frame_left"},
                                   {n - 2, "6.second_newest_left"},
                                   {n - 3, "6.third_newest_left"},
                                   {1, "6.second_oldest_left"}}) {
    if (got == Positions(before, left)) cause = that;
  }
  Fail({AfterSlide("6.the_frames", flag), Word(right), Word(got), cause, "6i"});
}

Transform CameraOf(const Window& window, int frame) {
  const VertexPose& pose = *window.frames[static_cast<size_t>(window.IndexOf(frame))].pose;
  const Transform T_B_C = window.T_B_C();
  return {pose.q() * T_B_C.q, pose.p() + pose.q() * T_B_C.p};
}

// Why a depth in the new host's camera is not `depth`: it was not moved at all, or mistakes of 6k.
std::pair<const char*, const char*> CauseOfDepth(const Transform& T_W_C, const Vec3& p_W, double before, double depth,
                                                 double got) {
  if (std::abs(got - before) < 1e-9 * std::abs(before)) return {"6.depth_of_old_host", "6i"};
  const Vec3 d = p_W - T_W_C.p, d_C = T_W_C.q.conjugate() * d;
  const std::pair<const char*, double> mistakes[] = {{"6.depth_turned_back", (T_W_C.q * d).z()},
                                                     {"6.depth_is_distance", d.norm()},
                                                     {"6.depth_from_origin", (T_W_C.q.conjugate() * p_W).z()},
                                                     {"6.depth_is_inverse", 1.0 / depth},
                                                     {"6.depth_without_sign", std::abs(d_C.z())}};
  for (const auto& [cause, answer] : mistakes) {
    if (std::abs(got - answer) < 1e-9 * std::abs(answer)) return {cause, "6k 6i"};
  }
  return {"6.depth_in_next_host", "6k 6i"};
}

// Every landmark, by whom it is seen, and its depth.
void CheckLandmarks(const Window& before, const Slid& after, size_t gone, const char* flag) {
  const int left = before.frames[gone].id;
  for (const auto& [track, landmark] : before.landmarks) {
    const Text name("scene.landmark", {{"n", Word(track)}});
    std::vector<int> right, got;
    for (const auto& seen : landmark.seen) {
      if (seen.frame != left) right.push_back(seen.frame - kFirstId);
    }
    const bool hosted = landmark.Host() == left;
    if (right.empty() || (hosted && landmark.inverse_depth && right.size() == 1)) right.clear();
    const auto found = after.seen.find(track);
    if (found != after.seen.end()) {
      for (const int frame : found->second) got.push_back(frame - kFirstId);
    }
    if (got != right) {
      const auto text = [](const std::vector<int>& frames) {
        return frames.empty() ? "6.erased" : Text("6.seen_frames", {{"frames", Word(Join(frames))}});
      };
      const bool still = std::count(got.begin(), got.end(), left - kFirstId) > 0;
      Fail({AfterSlide(name, flag), text(right), text(got),
            still && got.size() == right.size() ? "6.other_frame_forgotten"
            : still                             ? "6.observation_left_behind"
            : got.empty()                       ? "6.thrown_away"
                                                : "6.other_observations_lost",
            "6i"});
    }
    if (got.empty() || !landmark.inverse_depth) continue;
    const Transform T_W_C = CameraOf(before, found->second.front());
    const Vec3 p_W = LandmarkInWorld(before, landmark);
    const double z = (T_W_C.q.conjugate() * (p_W - T_W_C.p)).z(), depth = z > 0.0 ? z : kInitialDepth;
    const auto inverse_depth = after.inverse_depths.find(track);
    const double got_depth = 1.0 / (inverse_depth == after.inverse_depths.end() ? 0.0 : inverse_depth->second);
    if (std::abs(got_depth - depth) < 1e-9 * depth) continue;
    const auto [cause, todo] = CauseOfDepth(T_W_C, p_W, 1.0 / landmark.inverse_depth->InverseDepth(), depth, got_depth);
    Fail({AfterSlide({"6.depth", {{"landmark", name}}}, flag), Word(Number(depth) + " m"),
          Word(Number(got_depth) + " m"), cause, todo});
  }
}

void CheckImu(const Window& before, const Slid& after, size_t gone, const char* flag) {
  const auto own = [&](size_t k) { return before.frames[k].imu; };
  for (size_t k = 0; k < after.frames.size(); ++k) {
    const size_t old = k < gone ? k : k + 1;
    ImuInterval right = IntervalOf(own(old));
    if (k == 0) right = {};
    if (gone > 0 && old == gone + 1) right = Merged(*own(gone), *own(old));
    const ImuInterval& got = after.imu[k];
    if (got.Is(right)) continue;
    Text cause = "6.other_IMU_changed";
    if (k == 0) {
      cause = after.has_imu[1] ? "6.first_frame_none_before" : "6.iterator_after_erase";
    } else if (gone > 0 && old == gone + 1) {
      cause = "6.IMU_not_merged";
      if (got.Is({})) cause = "6.IMU_between_two_frames_gone";
      if (got.Is(IntervalOf(own(old)))) cause = "6.leaving_samples_lost";
      if (got.Is(IntervalOf(own(gone)))) cause = "6.own_samples_lost";
      if (got.Is(Merged(*own(gone), *own(gone)))) cause = "6.appended_to_itself";
      if (got.Is(Merged(*own(old), *own(gone)))) cause = "6.pieces_in_wrong_order";
    } else if (gone == 0 && k == 1 && std::abs(got.seconds - right.seconds) > 1e-9) {
      cause = "6.MARGIN_OLD_merges_nothing";
    }
    Fail({AfterSlide({"6.IMU_before_frame", {{"k", Word(k)}}}, flag), Word(Number(right.seconds) + " s"),
          Word(Number(got.seconds) + " s"), cause, "6i"});
  }
}

void CheckSlid(const Window& before, const Slid& after, MarginalizationFlag flag) {
  const bool old = flag == MarginalizationFlag::kOld;
  const char* const name = old ? "kOld" : "kSecondNew";
  const size_t gone = old ? 0 : before.frames.size() - 2;
  CheckFrames(before, after, gone, name);
  CheckLandmarks(before, after, gone, name);
  CheckImu(before, after, gone, name);
}

void CheckSlide(MarginalizationFlag flag, const char* name) {
  WindowScene scene(name);
  CheckSlid(scene.window, Slid(Ask("SlideWindow", scene, {{"flag", flag}})), flag);
}

TEST(Stage6, SlidesTheOldestFrameOut) {
  for (const char* scene : {"full window", "landmark behind"}) CheckSlide(MarginalizationFlag::kOld, scene);
}
TEST(Stage6, SlidesTheSecondNewestFrameOut) {
  for (const char* scene : {"full window", "long window"}) CheckSlide(MarginalizationFlag::kSecondNew, scene);
}

// ---- 6j DetectFailure ------------------------------------------------------------------------------------------------

Text NameOf(Failure failure) {
  static const std::array names{"kNone", "kAccelerometerBias", "kGyroscopeBias", "kPositionJump", "kHeightJump"};
  const auto number = static_cast<size_t>(failure);
  return number < names.size() ? Word(names[number]) : "6.another_one";
}

struct FailureCase {
  Text what;
  double b_a, b_g;
  Vec3 step;
  Failure right;
  Text cause;
};

// The values in three unlike components, each below the threshold that the norm is held against; at the threshold itself
// in one, for the norm to be exact.
Vec3 OfNorm(double norm) { return norm == 2.5 || norm == 1.0 ? Vec3(0, 0, -norm) : norm * Vec3(2, -2, 1) / 3.0; }

std::vector<FailureCase> FailureCases() {
  const Vec3 small(0.3, 0.1, 0.1);
  const Failure none = Failure::kNone;
  const auto of = [](const char* what, const char* x) { return Text(what, {{"x", Word(x)}}); };
  return {
      {"6.nothing_unusual", 0.1, 0.01, small, none, "6.condition_holds_wrongly"},
      {of("6.b_a_m_s", "2.51"), 2.51, 0.01, small, Failure::kAccelerometerBias, "6.accelerometer_bias"},
      {of("6.b_a_m_s", "2.49"), 2.49, 0.01, small, none, "6.accelerometer_limit"},
      {of("6.b_g_rad_s", "1.01"), 0.1, 1.01, small, Failure::kGyroscopeBias, "6.gyroscope_bias"},
      {"6.b_g_in_degrees", 0.1, 0.99, small, none, "6.gyroscope_limit"},
      {of("6.step_m", "5.01"), 0.1, 0.01, 5.01 * Vec3(-0.6, 0.8, 0), Failure::kPositionJump, "6.position_jump"},
      {"6.step_level_and_upwards", 0.1, 0.01, Vec3(-2.976, 3.968, 0.9), Failure::kPositionJump,
       "6.length_step_counts_height"},
      {of("6.step_m", "4.99"), 0.1, 0.01, 4.99 * Vec3(0.6, 0.8, 0), none, "6.step_limit"},
      {of("6.step_m_upwards", "2.01"), 0.1, 0.01, Vec3(0, 0, 2.01), Failure::kHeightJump, "6.height_jump"},
      {of("6.step_m_upwards", "1.01"), 0.1, 0.01, Vec3(0, 0, 1.01), Failure::kHeightJump, "6.height_in_whole_meters"},
      {of("6.step_m_downwards", "1.01"), 0.1, 0.01, Vec3(0, 0, -1.01), Failure::kHeightJump, "6.downwards_counts_too"},
      {of("6.step_m_upwards", "0.99"), 0.1, 0.01, Vec3(0, 0, 0.99), none, "6.height_limit"},
      {"6.all_at_their_limits", 2.5, 1.0, Vec3(3, -4, 0), none, "6.value_limit_no_failure"},
      {of("6.step_m_downwards", "1"), 0.1, 0.01, Vec3(0, 0, -1), none, "6.value_limit_no_failure"},
  };
}

TEST(Stage6, FailuresAtTheirThresholds) {
  for (const FailureCase& c : FailureCases()) {
    for (const bool tracks : {true, false}) {
      WindowScene scene(tracks ? "full window" : "frames");
      Window& window = scene.window;
      const Frame &newest = window.frames.back(), &oldest = window.frames.front();
      Vec9 v_ba_bg;
      v_ba_bg << 8.0, 0.0, 0.0, OfNorm(c.b_a), OfNorm(c.b_g);
      newest.speed_bias->SetEstimate(v_ba_bg);
      v_ba_bg << Vec3::Zero(), Vec3(9, 0, 0), Vec3(9, 0, 0);
      oldest.speed_bias->SetEstimate(v_ba_bg);
      const Vec3 p = (8.0 * newest.pose->p()).array().round() / 8.0;  // of few digits, so that steps are exact
      newest.pose->SetPose(ExpSO3(Vec3(1.2, 0.3, 0.9)), p);  // a fast turn is no failure, and up is not the body's z
      const Vec3 last_p = p - c.step;
      (window.frames.end() - 2)->pose->SetPose(Qd::Identity(), last_p + 0.05 * c.step);  // neither end of the step
      const auto got = static_cast<Failure>(Ask("DetectFailure", scene, {{"last_p", last_p}}).Int("failure"));
      if (got == c.right) continue;
      const bool not_the_height =
          got == Failure::kHeightJump && c.right != Failure::kPositionJump && std::abs(c.step.z()) < 0.95;
      const bool unusual = c.b_a > 1.0 || c.b_g > 0.5 || c.step.norm() > 0.9;
      const bool another = (got == Failure::kAccelerometerBias && c.b_a < 1.0) ||
                           (got == Failure::kGyroscopeBias && c.b_g < 0.5) ||
                           (got == Failure::kPositionJump && c.step.norm() < 1.0);
      Fail({Text("6.detect_failure", {{"what", tracks ? c.what : Text("6.no_tracks", {{"what", c.what}})}}),
            NameOf(c.right), NameOf(got),
            not_the_height       ? Text("6.height_is_z", {{"z", Word(c.step.z())}})
            : unusual && another ? Text("6.another_quantity_compared")
                                 : c.cause,
            "6j"});
    }
  }
}

// ---- all of it -------------------------------------------------------------------------------------------------------

DropSet RightDropSet(MarginalizationFlag flag, const Window& window) {
  if (flag == MarginalizationFlag::kOld) return RightMarginOld(window);
  const auto& pose = window.frames[window.frames.size() - 2].pose;
  return Holds(window.prior->Vertices(), pose) ? DropSet{{window.prior}, {pose}} : DropSet{};
}

void SlideRightly(MarginalizationFlag flag, Window* window) {
  auto& frames = window->frames;
  const bool oldest = flag == MarginalizationFlag::kOld;
  const size_t gone = oldest ? 0 : frames.size() - 2;
  ForgetObservations(frames[gone].id, &DepthInCamera, window);
  const auto joined = oldest ? nullptr : frames[gone].imu;
  if (joined) joined->Append(*frames[gone + 1].imu);
  frames[gone + 1].imu = joined;
  frames.erase(frames.begin() + static_cast<ptrdiff_t>(gone));
}

// The prior on the vertices that the submission's is on; what it says is compared.
void CheckPrior(const Answer& answer, const std::string& number, const MarginalSystem& right, WindowScene* scene) {
  const VertexList kept = At<Vertex>(answer.Vector("prior" + number), scene->Vertices(), nullptr);
  if (kept != right.kept) Fail({"6.prior_on_other_vertices"});
  const MatXX& J = answer["J" + number];
  const VecX r0 = answer.Vector("r0" + number);
  if (r0.size() != J.rows()) throw WireError("J and r0 do not fit together");
  const auto require = [](const char* quantity, const MatXX& meant, const MatXX& got) {
    Require({{"6.of_sliding_prior", {{"quantity", Word(quantity)}}}, {}, {}, {}, 1e-5}, meant, got);
  };
  require("JᵀJ", right.H, J.transpose() * J);
  require("−Jᵀr₀", right.b, -J.transpose() * r0);
}

// Two windows slide side by side, the submission's and one that is right, and are compared after each step.
TEST(Stage6, TheWindowSlidesAgainAndAgain) {
  WindowScene scene("sliding window");
  Window& window = scene.window;
  using Flag = MarginalizationFlag;
  std::vector<Flag> flags{Flag::kOld, Flag::kOld, Flag::kSecondNew, Flag::kOld, Flag::kSecondNew, Flag::kOld};
  Random random(Seed(70));
  while (flags.size() < 15) flags.push_back(random.Bits() % 2 ? Flag::kOld : Flag::kSecondNew);
  VecX numbers(flags.size());
  std::transform(flags.begin(), flags.end(), numbers.data(), [](Flag flag) { return static_cast<double>(flag); });
  const Answer answer = Ask("SlideRepeatedly", scene, {{"flags", numbers}});
  for (size_t k = 0; k < flags.size(); ++k) {
    const std::string number = Numbered("", k);
    scene.Step();
    const DropSet right = RightDropSet(flags[k], window), drop = DropSetIn(answer, &scene, number);
    if (!Same(drop, right)) Fail({{"6.drop_set_window_slid", {{"set", Inventory(drop)}}}});
    if (!drop.edges.empty()) {
      CheckPrior(answer, number, EliminateVertices(right.edges, right.vertices), &scene);
      window.prior = std::make_shared<EdgePrior>(Marginalize(right.edges, right.vertices));
    }
    const Slid slid(answer, number);
    if (slid.frames.size() != 5u) Fail({"6.window_not_keep_size"});
    for (const auto& [id, frames] : slid.seen) {
      for (const int frame : frames) {
        if (std::count(slid.frames.begin(), slid.frames.end(), frame) > 0) continue;
        Fail({{"6.gone_frame_sees_landmark", {{"n", Word(id)}}}});
      }
    }
    CheckSlid(window, slid, flags[k]);
    SlideRightly(flags[k], &window);
  }
}

}  // namespace
}  // namespace ch5::homework
