/// OKVIS's window: K keyframes, which may be old and far apart, and the S newest frames.
///
///   k₁ … k_K │ c │ S newest          poses of all; speed and biases of the S newest only
///             ╰─ the frame that has just become too old to be among them
///
/// Source: Leutenegger et al., "Keyframe-based visual-inertial odometry using nonlinear optimization", IJRR 2015, §4.3.

#include <algorithm>
#include <set>

#include "ch5_backend/consistency/position_yaw_prior.h"
#include "ch5_backend/math/option_checks.h"
#include "ch5_backend/window/image_overlap.h"
#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/policy.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5 {
namespace {

class OkvisPolicy : public WindowPolicy {
 public:
  explicit OkvisPolicy(const OkvisOptions& options) : options_(options) {}

  std::string Name() const override { return "okvis"; }

  void NoteNewFrame(Window* window) override {
    Frame& newest = window->frames.back();
    newest.is_keyframe = IsKeyframe(*window);
    if (!window->gauge_prior && !window->prior_fixes_gauge) {
      window->gauge_prior = MakePositionYawPrior(window->frames.front().pose, options_.gauge_information);
    }
  }

  bool Uses(const Window&, const WindowLandmark& landmark) const override { return landmark.seen.size() >= 2; }

  SolveOptions Options() const override {
    SolveOptions options;
    options.algorithm = Algorithm::kDogleg;
    options.max_iterations = options_.max_iterations;
    options.cost_tolerance = options_.cost_tolerance;
    options.landmark_steps = options_.landmark_steps;
    return options;
  }

  void Slide(Window* window) override {
    const int walked = static_cast<int>(window->frames.size()) - options_.temporal_frames;
    if (walked <= 0) return;
    const Plan plan = MakePlan(walked, *window);
    Marginalize(plan, window);
    for (const int track : plan.dropped_landmarks) window->landmarks.erase(track);
    for (const int frame : plan.dropped_frames) ForgetObservations(frame, DepthInCamera, window);
    for (int k = 0; k < walked; ++k) window->frames[static_cast<size_t>(k)].speed_bias = nullptr;
    auto& frames = window->frames;
    frames.erase(std::remove_if(frames.begin(), frames.end(),
                                [&](const Frame& frame) { return plan.dropped_frames.count(frame.id) > 0; }),
                 frames.end());
    if (plan.renew_gauge_prior)
      window->gauge_prior = MakePositionYawPrior(frames.front().pose, options_.later_gauge_information);
  }

  size_t MostFrames() const override { return static_cast<size_t>(options_.keyframes + options_.temporal_frames); }

 private:
  // What leaves the window.
  struct Plan {
    std::vector<std::shared_ptr<Vertex>> drop;  // marginalized
    std::set<int> dropped_frames;               // ids
    Array<int> dropped_landmarks;               // track ids: marginalized, or discarded because seen once
    bool renew_gauge_prior = false;
  };

  // Walks from the newest frame that is not among the S newest to the oldest.
  Plan MakePlan(int walked, const Window& window) const {
    Plan plan;
    int keyframes = 0;
    for (int k = walked - 1; k >= 0; --k) {
      const Frame& frame = window.frames[static_cast<size_t>(k)];
      if (frame.speed_bias) plan.drop.push_back(frame.speed_bias);
      if (frame.is_keyframe && keyframes < options_.keyframes) {
        ++keyframes;
        continue;
      }
      plan.drop.push_back(frame.pose);
      plan.dropped_frames.insert(frame.id);
      if (window.gauge_prior && window.gauge_prior->Vertices().front() == frame.pose) plan.renew_gauge_prior = true;
    }
    const int c = window.frames[static_cast<size_t>(walked - 1)].id;
    for (const auto& [id, landmark] : window.landmarks) {
      const auto sees = [&landmark = landmark](int frame) { return landmark.In(frame) != nullptr; };
      const bool touched = std::any_of(plan.dropped_frames.begin(), plan.dropped_frames.end(), sees);
      if (!touched || landmark.seen.back().frame >= c) continue;
      plan.dropped_landmarks.push_back(id);
      if (landmark.inverse_depth && landmark.seen.size() >= 2) plan.drop.push_back(landmark.inverse_depth);
    }
    return plan;
  }

  // With the edges at the dropped vertices, except the gauge prior, which is renewed, and the observations of landmarks
  // that stay: those observations are lost, so that none is used twice.
  static void Marginalize(const Plan& plan, Window* window) {
    const std::set<std::shared_ptr<Vertex>> drop(plan.drop.begin(), plan.drop.end());
    std::vector<std::shared_ptr<Edge>> edges = EdgesAt(window->graph, plan.drop);
    const auto is_left_out = [&](const std::shared_ptr<Edge>& edge) {
      return edge == window->gauge_prior ||
             std::any_of(edge->Vertices().begin(), edge->Vertices().end(), [&](const auto& vertex) {
               return vertex->GetRole() == Role::kLandmark && drop.count(vertex) == 0;
             });
    };
    edges.erase(std::remove_if(edges.begin(), edges.end(), is_left_out), edges.end());
    if (edges.empty()) return;
    if (window->prior && std::find(edges.begin(), edges.end(), window->prior) == edges.end()) {
      edges.push_back(window->prior);
    }
    ReplacePrior(edges, plan.drop, window);
  }

  // A keyframe unless the image still sees most of what the last keyframe saw, and from there.
  bool IsKeyframe(const Window& window) const {
    const auto& frames = window.frames;
    const auto last =
        std::find_if(frames.rbegin() + 1, frames.rend(), [](const auto& frame) { return frame.is_keyframe; });
    if (last == frames.rend()) return true;
    const ImageOverlap overlap = ImageOverlapOf(window, last->id, frames.back().id);
    return !(overlap.hull_ratio > options_.hull_ratio && overlap.match_ratio > options_.match_ratio &&
             overlap.angle < options_.view_angle);
  }

  OkvisOptions options_;
};

}  // namespace

void OkvisOptions::Validate() const {
  CheckOption("OkvisOptions::keyframes", keyframes, 1);
  CheckOption("OkvisOptions::temporal_frames", temporal_frames, 2);
  CheckOption("OkvisOptions::hull_ratio", hull_ratio, 0);
  CheckOption("OkvisOptions::match_ratio", match_ratio, 0);
  CheckPositive("OkvisOptions::view_angle", view_angle);
  CheckPositive("OkvisOptions::gauge_information", gauge_information);
  CheckPositive("OkvisOptions::later_gauge_information", later_gauge_information);
  CheckOption("OkvisOptions::max_iterations", max_iterations, 1);
  CheckOption("OkvisOptions::cost_tolerance", cost_tolerance, 0);
  CheckOption("OkvisOptions::landmark_steps", landmark_steps, 0);
}

std::unique_ptr<WindowPolicy> MakeOkvisPolicy(const OkvisOptions& options) {
  options.Validate();
  return std::make_unique<OkvisPolicy>(options);
}

}  // namespace ch5
