#include <Eigen/Core>
#include <algorithm>
#include <set>

#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/policy.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5 {
namespace {

class VinsPolicy : public WindowPolicy {
 public:
  explicit VinsPolicy(const VinsOptions& options) : options_(options) {}

  std::string Name() const override { return "vins"; }

  void NoteNewFrame(Window* window) override {
    flag_ = SecondNewestIsKeyframe(*window) ? MarginalizationFlag::kOld : MarginalizationFlag::kSecondNew;
    const Frame& oldest = window->frames.front();
    q0_ = oldest.pose->q();
    p0_ = oldest.pose->p();
  }

  // Seen twice, and hosted before the last three frames; where images are far apart, these three would be too long a time
  // without landmarks.
  bool Uses(const Window& window, const WindowLandmark& landmark) const override {
    const size_t n = window.frames.size();
    const bool is_slow = n > 1 && window.frames[n - 1].t - window.frames[n - 2].t > options_.slow_seconds;
    const int newest_host = static_cast<int>(n) - (is_slow ? 2 : 4);
    return landmark.seen.size() >= 2 && window.IndexOf(landmark.Host()) <= newest_host;
  }

  SolveOptions Options() const override {
    SolveOptions options;
    options.algorithm = Algorithm::kDogleg;
    options.max_iterations = options_.max_iterations;
    options.cost_tolerance = options_.cost_tolerance;
    options.landmark_steps = options_.landmark_steps;
    if (options_.max_solve_seconds) {
      const double budget = *options_.max_solve_seconds * (flag_ == MarginalizationFlag::kOld ? 0.8 : 1.0);
      options.callback = [budget](const IterationInfo& info) { return info.seconds < budget; };
    }
    return options;
  }

  // The solve may move all frames together, since no measurement observes position and yaw: the oldest frame gets its
  // former ones back, and the others move along.
  void AfterSolve(Window* window) override {
    if (window->prior_fixes_gauge) return;
    const Frame& oldest = window->frames.front();
    const Vec3 p0_solved = oldest.pose->p();
    const Qd turn = TwistAboutGravity(q0_ * oldest.pose->q().conjugate());
    for (const Frame& frame : window->frames) {
      frame.pose->SetPose(turn * frame.pose->q(), turn * (frame.pose->p() - p0_solved) + p0_);
      Vec9 v_ba_bg = frame.speed_bias->GetEstimate();
      v_ba_bg.head<3>() = turn * frame.speed_bias->v();
      frame.speed_bias->SetEstimate(v_ba_bg);
    }
  }

  void Slide(Window* window) override {
    if (window->frames.size() <= MostFrames()) return;
    const bool is_old = flag_ == MarginalizationFlag::kOld, keeps_own = !is_old && SecondNewestHasOwn(*window);
    DropSet drop = is_old      ? DropSetOfMarginOld(*window)
                   : keeps_own ? DropSetOfOwnAndImu(*window)
                               : DropSetOfMarginSecondNew(*window);
    if (!options_.reuse_observations && is_old) UseObservationsOnce(window, &drop);
    // A prior that own edges have begun need not be at the oldest frame.
    const bool has_prior = std::find(drop.edges.begin(), drop.edges.end(), window->prior) != drop.edges.end();
    if (!drop.edges.empty() && window->prior && !has_prior) drop.edges.push_back(window->prior);
    if (!drop.edges.empty()) ReplacePrior(drop.edges, drop.vertices, window);
    SlideWindow(flag_, window);
    window->frames.back().prior_has_imu |= keeps_own;
  }

  size_t MostFrames() const override { return static_cast<size_t>(options_.window_size); }

 private:
  // Whether the second newest frame cannot be left out as an image is: an edge of one's own is there, or the prior has
  // the IMU before it already.
  static bool SecondNewestHasOwn(const Window& window) {
    const Frame& second = window.frames[window.frames.size() - 2];
    const auto is_its = [&](const auto& vertex) { return vertex == second.pose || vertex == second.speed_bias; };
    return second.prior_has_imu || std::any_of(window.own_edges.begin(), window.own_edges.end(), [&](const auto& edge) {
             return std::any_of(edge->Vertices().begin(), edge->Vertices().end(), is_its);
           });
  }

  // MARGIN_SECOND_NEW that loses nothing but the image: the frame's states go with all edges there that are no observation
  // of a landmark. The IMU on both sides of it ties what its own edges know to the frames that stay.
  static DropSet DropSetOfOwnAndImu(const Window& window) {
    const Frame& second = window.frames[window.frames.size() - 2];
    DropSet drop;
    drop.vertices = {second.pose, second.speed_bias};
    for (const auto& edge : EdgesAt(window.graph, drop.vertices)) {
      const bool is_seen = std::any_of(edge->Vertices().begin(), edge->Vertices().end(),
                                       [](const auto& vertex) { return vertex->GetRole() == Role::kLandmark; });
      if (!is_seen) drop.edges.push_back(edge);
    }
    return drop;
  }

  // Uses each observation once: landmarks that the newest frame still sees stay out of the prior with all their edges;
  // the others are marginalized with all their observations.
  static void UseObservationsOnce(Window* window, DropSet* drop) {
    std::set<const Vertex*> active;
    for (auto it = window->landmarks.begin(); it != window->landmarks.end();) {
      const WindowLandmark& landmark = it->second;
      const bool is_active = landmark.seen.back().frame == window->frames.back().id;
      const bool is_dropped = landmark.inverse_depth && landmark.Host() == window->frames.front().id && !is_active;
      if (is_active) active.insert(landmark.inverse_depth.get());
      it = is_dropped ? window->landmarks.erase(it) : std::next(it);
    }
    const auto is_active = [&](const auto& vertex) { return active.count(vertex.get()) > 0; };
    auto& vertices = drop->vertices;
    vertices.erase(std::remove_if(vertices.begin(), vertices.end(), is_active), vertices.end());
    auto& edges = drop->edges;
    edges.erase(std::remove_if(edges.begin(), edges.end(),
                               [&](const auto& edge) {
                                 return std::any_of(edge->Vertices().begin(), edge->Vertices().end(), is_active);
                               }),
                edges.end());
  }

  bool SecondNewestIsKeyframe(const Window& window) const {
    const size_t n = window.frames.size();
    if (n < 3) return true;
    if (window.frames[n - 1].t - window.frames[n - 3].t > options_.keyframe_seconds) return true;
    const int newest = window.frames[n - 1].id, second = window.frames[n - 2].id, third = window.frames[n - 3].id;
    if (ParallaxBetween(window, second, newest).common < options_.least_tracked) return true;
    const Parallax parallax = ParallaxBetween(window, third, second);
    return parallax.common == 0 || parallax.mean >= options_.parallax_pixels / window.calibration.FocalLength();
  }

  VinsOptions options_;
  MarginalizationFlag flag_ = MarginalizationFlag::kOld;
  Qd q0_ = Qd::Identity();
  Vec3 p0_ = Vec3::Zero();
};

}  // namespace

void VinsOptions::Validate() const {
  CheckOption("VinsOptions::window_size", window_size, 4);  // three newest frames, and a host before them
  CheckOption("VinsOptions::least_tracked", least_tracked, 0);
  CheckOption("VinsOptions::parallax_pixels", parallax_pixels, 0);
  CheckPositive("VinsOptions::keyframe_seconds", keyframe_seconds);
  CheckPositive("VinsOptions::slow_seconds", slow_seconds);
  CheckOption("VinsOptions::max_iterations", max_iterations, 1);
  CheckOption("VinsOptions::cost_tolerance", cost_tolerance, 0);
  CheckOption("VinsOptions::landmark_steps", landmark_steps, 0);
  if (max_solve_seconds) CheckOption("VinsOptions::max_solve_seconds", *max_solve_seconds, 0);
}

std::unique_ptr<WindowPolicy> MakeVinsPolicy(const VinsOptions& options) {
  options.Validate();
  return std::make_unique<VinsPolicy>(options);
}

}  // namespace ch5
