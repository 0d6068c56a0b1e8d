#include "ch5_homework/judge/remote/window_numbers.h"

#include <algorithm>

namespace ch5::homework {

// ---- a window --------------------------------------------------------------------------------------------------------

WindowNumbers NumbersOf(const Window& window, const VertexList& known) {
  const auto slot = [&](const std::shared_ptr<Vertex>& vertex) {
    return vertex ? SlotNumbers{PlaceOf(vertex, known), vertex->Parameters()} : SlotNumbers{};
  };
  WindowNumbers numbers;
  for (const Frame& frame : window.frames) {
    FrameNumbers& one = numbers.frames.emplace_back();
    one.id = frame.id;
    one.t = frame.t;
    one.pose = slot(frame.pose);
    one.speed_bias = slot(frame.speed_bias);
    one.has_imu = frame.imu != nullptr;
    if (!one.has_imu) continue;
    one.b_a = frame.imu->BiasAccelerometer();
    one.b_g = frame.imu->BiasGyroscope();
    one.imu = frame.imu->Samples();
  }
  for (const auto& [track, landmark] : window.landmarks) {
    numbers.landmarks.push_back({track, slot(landmark.inverse_depth), landmark.seen});
  }
  numbers.has_prior = window.prior != nullptr;
  return numbers;
}

namespace {

// The vertex of the slot; `made` if it is new.
template <typename V>
std::shared_ptr<V> VertexOf(const SlotNumbers& slot, const VertexList& known, std::shared_ptr<V> made) {
  if (slot.place == kNull) return nullptr;
  if (slot.place != kUnknown) made = std::dynamic_pointer_cast<V>(At<Vertex>({slot.place}, known)[0]);
  if (!made) throw WireError("a vertex of another type than its place asks for");
  if (slot.x.size() != made->Dimension()) throw WireError("a vertex of another size");
  if (!slot.x.allFinite()) throw WireError("a vertex holds a number that is not finite");
  made->Parameters() = slot.x;
  return made;
}

bool Same(const ImuSample& a, const ImuSample& b) {
  return a.dt == b.dt && a.acceleration == b.acceleration && a.gyroscope == b.gyroscope;
}

// The interval of the window that the samples are, or begin with, goes on with the others: so it keeps its noise.
std::shared_ptr<Preintegration> ImuOf(const FrameNumbers& numbers, const Window& window) {
  const auto& samples = numbers.imu;
  std::shared_ptr<Preintegration> begun;
  for (const Frame& frame : window.frames) {
    if (!frame.imu || frame.imu->BiasAccelerometer() != numbers.b_a || frame.imu->BiasGyroscope() != numbers.b_g)
      continue;
    const auto& own = frame.imu->Samples();
    if (own.size() > samples.size() || !std::equal(own.begin(), own.end(), samples.begin(), &Same)) continue;
    if (own.size() == samples.size()) return frame.imu;
    begun = std::make_shared<Preintegration>(*frame.imu);
  }
  if (samples.empty()) throw WireError("an IMU interval without samples");
  if (!begun) begun = std::make_shared<Preintegration>(samples[0], numbers.b_a, numbers.b_g, ImuNoise{});
  for (size_t k = begun->Samples().size(); k < samples.size(); ++k) begun->Add(samples[k]);
  return begun;
}

}  // namespace

void SetInto(const WindowNumbers& numbers, const VertexList& known, Window* window) {
  std::vector<Frame> frames;
  for (const FrameNumbers& one : numbers.frames) {
    Frame& frame = frames.emplace_back();
    frame.id = one.id;
    frame.t = one.t;
    frame.pose = VertexOf(one.pose, known, std::make_shared<VertexPose>());
    frame.speed_bias = VertexOf(one.speed_bias, known, std::make_shared<VertexSpeedBias>());
    if (!frame.pose || !frame.speed_bias) throw WireError("a frame without pose, or without speed and biases");
    if (one.has_imu) frame.imu = ImuOf(one, *window);
  }
  window->frames = std::move(frames);
  window->landmarks.clear();
  for (const LandmarkNumbers& one : numbers.landmarks) {
    WindowLandmark& landmark = window->landmarks[one.track];
    landmark.seen = one.seen;
    landmark.inverse_depth = VertexOf(one.inverse_depth, known, std::make_shared<VertexInverseDepth>(0.0));
  }
  if (!numbers.has_prior) window->prior = nullptr;
}

// ---- a prior ---------------------------------------------------------------------------------------------------------

PriorNumbers NumbersOf(const Prior& prior, const VertexList& vertices) {
  return {PlacesOf(prior.vertices, vertices), prior.x0, prior.J, prior.r0};
}

Prior MakePrior(const PriorNumbers& numbers, const VertexList& vertices, const std::shared_ptr<Vertex>& foreign) {
  Prior prior;
  for (const int place : numbers.vertices) {
    if (place == kNull) throw WireError("a vertex of the prior is null");
    const bool known = place >= 0 && place < static_cast<int>(vertices.size());
    prior.vertices.push_back(known ? vertices[static_cast<size_t>(place)] : foreign);
  }
  if (numbers.J.rows() != numbers.r0.size()) throw WireError("J and r0 of the prior do not fit together");
  prior.x0 = numbers.x0;
  prior.J = numbers.J;
  prior.r0 = numbers.r0;
  return prior;
}

}  // namespace ch5::homework
