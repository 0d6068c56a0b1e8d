#include <array>
#include <cmath>
#include <optional>

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/experiments/studies/window/flight.h"
#include "ch5_backend/lab/panels.h"

namespace ch5::lab {
namespace {

constexpr int kImages = 30;
constexpr const char* kPolicies[] = {"vins", "okvis"};

/// One policy's flight: an answer for each image.
struct Flown {
  std::vector<Json> windows;
  std::vector<Vec3> positions;  // estimated, of the newest frame
};

struct FlightRun {
  FlightOptions options;
  std::vector<Vec3> truth;  // at the images
  std::array<Flown, 2> by_policy;
};

std::vector<Json> FramesOf(const Window& window) {
  std::vector<Json> frames;
  for (const Frame& frame : window.frames) {
    Json json;
    json.Add("id", frame.id).Add("keyframe", frame.is_keyframe).Add("speed", frame.speed_bias != nullptr);
    frames.push_back(json.Add("in_prior", IsInPrior(window, frame)).Add("p", frame.pose->p()));
  }
  return frames;
}

// The prior after the slide: its matrix, what it holds, and what it claims to know of yaw. (Of position it knows nothing, but for rounding.)
void AddPrior(const Window& window, Json* json) {
  if (!window.prior) return;
  const Prior& prior = window.prior->GetPrior();
  const MatXX H = prior.J.transpose() * prior.J;
  std::vector<Json> variables;
  int row = 0;
  for (const auto& vertex : prior.vertices) {
    Json variable;
    variable.Add("kind", vertex->TypeInfo()).Add("number", -1).Add("row", row).Add("rows", vertex->LocalDimension());
    for (const Frame& frame : window.frames) {
      const bool is_pose = vertex == frame.pose;
      if (is_pose || vertex == frame.speed_bias) {
        variable = Json().Add("kind", is_pose ? "pose" : "speed").Add("number", frame.id).Add("row", row);
        variable.Add("rows", vertex->LocalDimension());
      }
    }
    variables.push_back(variable);
    row += vertex->LocalDimension();
  }
  json->Add("variables", variables).Add("H", H);
  for (const GaugeLeak& leak : AuditPrior(prior)) {
    if (leak.direction == "yaw") json->Add("yaw_information", leak.information);
  }
}

Flown FlyThrough(const Recording& recording, const char* policy) {
  Flown flown;
  Fly(recording, kImages, MakeFlightPolicy(policy), [&](const Estimator& estimator, const WindowRow& row) {
    const Window& window = estimator.GetWindow();
    Json json;
    json.Add("frames", FramesOf(window)).Add("landmarks", row.report.landmarks);
    json.Add("cost", row.report.solve.final_cost);
    AddPrior(window, &json);
    flown.windows.push_back(json);
    if (row.report.state) flown.positions.push_back(row.report.state->T_W_B.p);
  });
  return flown;
}

FlightRun RunFlight(const FlightOptions& options) {
  const Recording recording = Flight(options);
  FlightRun run{options, {}, {}};
  for (size_t i = 0; i < kImages; ++i) {
    if (const auto state = StateAt(recording.truth, recording.frames[i].t)) run.truth.push_back(state->T_W_B.p);
  }
  for (size_t i = 0; i < 2; ++i) run.by_policy[i] = FlyThrough(recording, kPolicies[i]);
  return run;
}

// The last flight is kept: a student goes through its images one by one.
const FlightRun& FlightOf(const FlightOptions& options) {
  static std::optional<FlightRun> last;
  if (!last || last->options.camera_rate != options.camera_rate || last->options.max_tracks != options.max_tracks ||
      last->options.pixel_sigma != options.pixel_sigma) {
    last = RunFlight(options);
  }
  return *last;
}

}  // namespace

void WindowPanel(Query* query, Json* json) {
  FlightOptions options;
  options.camera_rate = query->Number("rate", 15.0, 5.0, 20.0);
  options.max_tracks = query->Whole("tracks", 12, 6, 30);
  options.pixel_sigma = query->Number("pixels", 1.0, 0.0, 5.0);
  const auto image = static_cast<size_t>(query->Whole("image", 12, 0, kImages - 1));
  if (!query->IsGood()) return;

  const FlightRun& run = FlightOf(options);
  json->Add("images", kImages).Add("image", static_cast<int>(image)).Add("truth", run.truth);
  for (size_t i = 0; i < 2; ++i) {
    const Flown& flown = run.by_policy[i];
    Json policy = flown.windows[image];
    policy.Add("positions", flown.positions);
    if (image < flown.positions.size() && image < run.truth.size()) {
      policy.Add("position_error", (flown.positions[image] - run.truth[image]).norm());
    }
    json->Add(kPolicies[i], policy);
  }
}

}  // namespace ch5::lab
