#include <algorithm>
#include <memory>

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/experiments/studies/window/flight.h"
#include "ch5_backend/lab/panels.h"

namespace ch5::lab {
namespace {

constexpr int kImages = 30;
constexpr const char* kPolicies[] = {"vins", "okvis"};

std::vector<Json> FramesOf(const Window& window) {
  std::vector<Json> frames;
  for (const Frame& frame : window.frames) {
    Json json;
    json.Add("id", frame.id).Add("keyframe", frame.is_keyframe).Add("speed", frame.speed_bias != nullptr);
    frames.push_back(json.Add("in_prior", IsInPrior(window, *frame.pose)).Add("p", frame.pose->p()));
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
    std::string kind = vertex->TypeInfo();
    int number = -1;
    for (const Frame& frame : window.frames) {
      if (vertex != frame.pose && vertex != frame.speed_bias) continue;
      kind = vertex == frame.pose ? "pose" : "speed";
      number = frame.id;
    }
    variables.push_back(VariableJson(kind, number, row, vertex->LocalDimension()));
    row += vertex->LocalDimension();
  }
  json->Add("variables", variables).Add("H", H);
  for (const GaugeLeak& leak : AuditPrior(prior)) {
    if (leak.direction == "yaw") json->Add("yaw_information", leak.information);
  }
}

// What the window's graph claims of x and y of its frames, and where they truly were.
void AddClaims(const Window& window, const std::vector<StampedState>& truth, Json* json) {
  if (!window.prior) return;
  const std::vector<PlacedFrame> placed = PlacedFrames(window, truth);
  if (placed.empty()) return;
  std::vector<Json> claims;
  for (size_t i = 1; i < placed.size(); ++i) {
    const PlacedFrame& frame = placed[i];
    if (frame.truth) claims.push_back(ClaimJson(frame.id, frame.p, *frame.truth, frame.claimed));
  }
  json->Add("held", placed.front().p).Add("claims", claims).Add("claim_limit", ClaimLimit());
}

/// One policy's flight, as far as it has been asked for: an answer for each image.
class PolicyFlight {
 public:
  PolicyFlight(const Recording& recording, const char* policy)
      : recording_(&recording), estimator_(StartFlight(recording, MakeFlightPolicy(policy))) {}

  std::vector<Json> windows;
  std::vector<Vec3> positions;  // estimated, of the newest frame

  // The images up to `image`, each with the measurements that it needs: one beyond its time, as FeedRecording asks for.
  void FlyUntil(size_t image) {
    while (windows.size() <= image) {
      const Image& frame = recording_->images[windows.size()];
      Recording part;
      part.images = {frame};
      while (measurement_ < recording_->imu.size() && (part.imu.empty() || part.imu.back().t < frame.t)) {
        part.imu.push_back(recording_->imu[measurement_++]);
      }
      FeedRecording(part, estimator_.get(), [&](const Estimator&, const ImageResult& row) { Note(row); });
    }
  }

 private:
  void Note(const ImageResult& row) {
    const Window& window = estimator_->GetWindow();
    Json json;
    json.Add("frames", FramesOf(window)).Add("landmarks", row.report.landmarks);
    json.Add("cost", row.report.solve.final_cost);
    AddPrior(window, &json);
    AddClaims(window, recording_->truth, &json);
    windows.push_back(json);
    if (row.report.state) positions.push_back(row.report.state->T_W_B.p);
  }

  const Recording* recording_;
  std::unique_ptr<Estimator> estimator_;
  size_t measurement_ = 0;  // the next one
};

/// The flight of both policies.
struct FlightRun {
  explicit FlightRun(const FlightOptions& asked) : options(asked), recording(Flight(asked)) {
    for (const char* policy : kPolicies) by_policy.emplace_back(recording, policy);
    for (size_t i = 0; i < kImages; ++i) {
      if (const auto state = StateAt(recording.truth, recording.images[i].t)) truth.push_back(state->T_W_B.p);
    }
  }

  FlightOptions options;
  Recording recording;
  std::vector<Vec3> truth;  // at the images
  std::vector<PolicyFlight> by_policy;
};

bool IsSame(const FlightOptions& a, const FlightOptions& b) {
  return a.camera_rate == b.camera_rate && a.max_tracks == b.max_tracks && a.pixel_sigma == b.pixel_sigma;
}

// The last two flights are kept: a student goes through their images one by one, side by side, and the page lets them grow
// bit by bit.
FlightRun* FlightOf(const FlightOptions& options) {
  static std::vector<std::unique_ptr<FlightRun>> kept;  // the latest one at the end
  auto run = std::find_if(kept.begin(), kept.end(), [&](const auto& one) { return IsSame(one->options, options); });
  if (run == kept.end()) {
    if (kept.size() == 2) kept.erase(kept.begin());
    kept.push_back(std::make_unique<FlightRun>(options));
  } else {
    std::rotate(run, run + 1, kept.end());
  }
  return kept.back().get();
}

}  // namespace

void WindowPanel(Query* query, Json* json) {
  FlightOptions options;
  options.camera_rate = query->Number("rate", 15.0, 5.0, 20.0);
  options.max_tracks = query->Whole("tracks", 12, 6, 30);
  options.pixel_sigma = query->Number("pixels", 1.0, 0.0, 5.0);
  const auto until = static_cast<size_t>(query->Whole("until", kImages - 1, 0, kImages - 1));
  const size_t image = std::min(until, static_cast<size_t>(query->Whole("image", 12, 0, kImages - 1)));
  if (!query->IsGood()) return;

  FlightRun* run = FlightOf(options);
  json->Add("images", kImages).Add("image", static_cast<int>(image)).Add("truth", run->truth);
  for (size_t i = 0; i < 2; ++i) {
    PolicyFlight& flight = run->by_policy[i];
    flight.FlyUntil(until);
    const auto end = flight.positions.begin() + std::min(flight.positions.size(), until + 1);
    Json policy = flight.windows[image];
    policy.Add("positions", std::vector<Vec3>(flight.positions.begin(), end));
    if (image < flight.positions.size() && image < run->truth.size()) {
      policy.Add("position_error", (flight.positions[image] - run->truth[image]).norm());
    }
    json->Add(kPolicies[i], policy);
  }
}

}  // namespace ch5::lab
