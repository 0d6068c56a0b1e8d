/// OKVIS's window: K keyframes, which may be old and far apart, and the S newest frames.
///
///   k₁ … k_K │ c │ S newest          poses of all; speed and biases of the S newest only
///             ╰─ the frame that has just become too old to be among them
///
/// Source: Leutenegger et al., "Keyframe-based visual-inertial odometry using nonlinear optimization", IJRR 2015, §IV-C.

#include <algorithm>
#include <set>

#include "ch5_backend/window/landmarks.h"
#include "ch5_backend/window/overlap.h"
#include "ch5_backend/window/place.h"
#include "ch5_backend/window/policy.h"
#include "ch5_backend/window/vins_window.h"

namespace ch5 {
namespace {

class OkvisPolicy : public WindowPolicy {
 public:
  explicit OkvisPolicy(const OkvisOptions& options) : options_(options) {}

  std::string Name() const override { return "okvis"; }

  void NoteNewFrame(Window* window) override {
    WindowFrame& newest = window->frames.back();
    newest.is_keyframe = IsKeyframe(*window);
    if (!window->gauge && !window->knows_place)
      window->gauge = HoldGauge(window->frames.front().pose, options_.gauge_information);
  }

  bool Uses(const Window&, const WindowLandmark& landmark) const override { return landmark.seen.size() >= 2; }

  SolveOptions Options() const override {
    SolveOptions options;
    options.algorithm = Algorithm::kDogleg;
    options.max_iterations = options_.max_iterations;
    options.cost_tolerance = options_.cost_tolerance;
    return options;
  }

  void Slide(Window* window) override {
    const int walked = static_cast<int>(window->frames.size()) - options_.temporal_frames;
    if (walked <= 0) return;
    const Plan plan = MakePlan(walked, *window);
    Marginalise(plan, window);
    for (const int track : plan.landmarks_gone) window->landmarks.erase(track);
    for (const int frame : plan.frames_gone) ForgetObservations(frame, window);
    for (int k = 0; k < walked; ++k) window->frames[static_cast<size_t>(k)].speed_bias = nullptr;
    auto& frames = window->frames;
    frames.erase(std::remove_if(frames.begin(), frames.end(),
                                [&](const WindowFrame& frame) { return plan.frames_gone.count(frame.id) > 0; }),
                 frames.end());
    if (plan.gauge_gone) window->gauge = HoldGauge(frames.front().pose, options_.later_gauge_information);
  }

  void SlideWithoutEstimate(Window* window) override {
    window->gauge = nullptr;
    const auto& frames = window->frames;
    if (static_cast<int>(frames.size()) <= options_.keyframes + options_.temporal_frames) return;
    const bool keep = frames[frames.size() - 2].is_keyframe;
    SlideWindow(keep ? MarginalizationFlag::kOld : MarginalizationFlag::kSecondNew, window);
  }

 private:
  // Who leaves, by the rules of the strategy.
  struct Plan {
    std::vector<std::shared_ptr<Vertex>> drop;
    std::set<int> frames_gone;
    std::vector<int> landmarks_gone;  // track ids: marginalised, or dropped for being seen once
    bool gauge_gone = false;
  };

  // Walks from the newest frame that is not among the S newest to the oldest.
  Plan MakePlan(int walked, const Window& window) const {
    Plan plan;
    int keyframes = 0;
    for (int k = walked - 1; k >= 0; --k) {
      const WindowFrame& frame = window.frames[static_cast<size_t>(k)];
      if (frame.speed_bias) plan.drop.push_back(frame.speed_bias);
      if (frame.is_keyframe && keyframes < options_.keyframes) {
        ++keyframes;
        continue;
      }
      plan.drop.push_back(frame.pose);
      plan.frames_gone.insert(frame.id);
      if (window.gauge && window.gauge->Vertices().front() == frame.pose) plan.gauge_gone = true;
    }
    const int c = window.frames[static_cast<size_t>(walked - 1)].id;
    for (const auto& [id, landmark] : window.landmarks) {
      const bool touched = std::any_of(landmark.seen.begin(), landmark.seen.end(), [&](const WindowObservation& seen) {
        return plan.frames_gone.count(seen.frame) > 0;
      });
      if (!touched || landmark.seen.back().frame >= c) continue;
      plan.landmarks_gone.push_back(id);
      if (landmark.inverse_depth && landmark.seen.size() >= 2) plan.drop.push_back(landmark.inverse_depth);
    }
    return plan;
  }

  // The edges at what leaves, without the gauge's, which is made anew, and without the observations of landmarks that
  // stay: those observations are lost, so that none is counted twice.
  static void Marginalise(const Plan& plan, Window* window) {
    const std::set<std::shared_ptr<Vertex>> drop(plan.drop.begin(), plan.drop.end());
    std::vector<std::shared_ptr<Edge>> edges = EdgesAt(window->graph, plan.drop);
    const auto is_left_out = [&](const std::shared_ptr<Edge>& edge) {
      return edge == window->gauge ||
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

  // A keyframe unless the image still shows most of what the last keyframe saw.
  bool IsKeyframe(const Window& window) const {
    const auto& frames = window.frames;
    const auto last =
        std::find_if(frames.rbegin() + 1, frames.rend(), [](const auto& frame) { return frame.is_keyframe; });
    if (last == frames.rend()) return true;
    const Overlap overlap = OverlapOf(window, last->id, frames.back().id);
    return !(overlap.hull > options_.hull_overlap && overlap.matches > options_.match_ratio);
  }

  OkvisOptions options_;
};

}  // namespace

std::unique_ptr<WindowPolicy> MakeOkvisPolicy(const OkvisOptions& options) {
  return std::make_unique<OkvisPolicy>(options);
}

}  // namespace ch5
