#include "ch5_homework/judge/remote/window_wire.h"

#include <algorithm>

namespace ch5::homework {

static Writer& operator<<(Writer& out, const ImuSample& s) { return out << s.dt << s.acceleration << s.gyroscope; }
static Reader& operator>>(Reader& in, ImuSample& s) { return in >> s.dt >> s.acceleration >> s.gyroscope; }
static Writer& operator<<(Writer& out, const WindowObservation& o) { return out << o.frame << o.x << o.velocity; }
static Reader& operator>>(Reader& in, WindowObservation& o) { return in >> o.frame >> o.x >> o.velocity; }

namespace {

bool Same(const ImuSample& a, const ImuSample& b) {
  return a.dt == b.dt && a.acceleration == b.acceleration && a.gyroscope == b.gyroscope;
}

ImuNumbers NumbersOf(const Preintegration* imu) {
  if (imu == nullptr) return {};
  return {true, imu->BiasAccelerometer(), imu->BiasGyroscope(), imu->Samples()};
}

// The piece of the window that the samples are, or begin with, goes on with the others: so it keeps its noise.
std::shared_ptr<Preintegration> MakeImu(const ImuNumbers& numbers, const Window& window) {
  if (!numbers.there) return nullptr;
  const auto& samples = numbers.samples;
  std::shared_ptr<Preintegration> begun;
  for (const WindowFrame& frame : window.frames) {
    if (!frame.imu || frame.imu->BiasAccelerometer() != numbers.b_a || frame.imu->BiasGyroscope() != numbers.b_g)
      continue;
    const auto& own = frame.imu->Samples();
    if (own.size() > samples.size() || !std::equal(own.begin(), own.end(), samples.begin(), &Same)) continue;
    if (own.size() == samples.size()) return frame.imu;
    begun = std::make_shared<Preintegration>(*frame.imu);
  }
  if (samples.empty()) throw WireError("an IMU piece without samples");
  if (!begun) begun = std::make_shared<Preintegration>(samples[0], numbers.b_a, numbers.b_g, ImuNoise{});
  for (size_t k = begun->Samples().size(); k < samples.size(); ++k) begun->Add(samples[k]);
  return begun;
}

template <typename V>
std::shared_ptr<V> VertexAt(int place, const VertexList& vertices) {
  if (place == kNull) return nullptr;
  if (place < 0 || place >= static_cast<int>(vertices.size())) throw WireError("a vertex that is not in the window");
  auto vertex = std::dynamic_pointer_cast<V>(vertices[static_cast<size_t>(place)]);
  if (!vertex) throw WireError("a vertex of another type than its place asks for");
  return vertex;
}

}  // namespace

// ---- reading and writing ---------------------------------------------------------------------------------------------

Writer& operator<<(Writer& out, const PriorNumbers& prior) {
  return out << prior.vertices << prior.x0 << prior.J << prior.r0;
}
Reader& operator>>(Reader& in, PriorNumbers& prior) { return in >> prior.vertices >> prior.x0 >> prior.J >> prior.r0; }

static Writer& operator<<(Writer& out, const FrameNumbers& frame) {
  out << frame.id << frame.t << frame.pose << frame.speed_bias << frame.imu.there << frame.imu.b_a << frame.imu.b_g
      << frame.imu.samples;
  return out;
}
static Reader& operator>>(Reader& in, FrameNumbers& frame) {
  in >> frame.id >> frame.t >> frame.pose >> frame.speed_bias >> frame.imu.there >> frame.imu.b_a >> frame.imu.b_g >>
      frame.imu.samples;
  return in;
}
static Writer& operator<<(Writer& out, const LandmarkNumbers& landmark) {
  return out << landmark.track << landmark.inverse_depth << landmark.seen;
}
static Reader& operator>>(Reader& in, LandmarkNumbers& landmark) {
  return in >> landmark.track >> landmark.inverse_depth >> landmark.seen;
}

Writer& operator<<(Writer& out, const WindowNumbers& w) {
  return out << w.graph << w.extrinsic << w.time_offset << w.frames << w.landmarks << w.has_prior << w.prior
             << w.prior_edge;
}
Reader& operator>>(Reader& in, WindowNumbers& w) {
  return in >> w.graph >> w.extrinsic >> w.time_offset >> w.frames >> w.landmarks >> w.has_prior >> w.prior >>
         w.prior_edge;
}

// ---- to numbers ------------------------------------------------------------------------------------------------------

PriorNumbers NumbersOf(const Prior& prior, const VertexList& vertices) {
  PriorNumbers numbers{{}, prior.x0, prior.J, prior.r0};
  for (const auto& vertex : prior.vertices) numbers.vertices.push_back(PlaceOf(vertex.get(), vertices));
  return numbers;
}

VertexList VerticesOf(const Window& window, VertexList known) {
  const auto add = [&](const std::shared_ptr<Vertex>& vertex) {
    if (PlaceOf(vertex.get(), known) == kUnknown) known.push_back(vertex);
  };
  for (const WindowFrame& frame : window.frames) {
    add(frame.pose);
    add(frame.speed_bias);
  }
  for (const auto& [track, landmark] : window.landmarks) add(landmark.inverse_depth);
  add(window.extrinsic);
  add(window.time_offset);
  return known;
}

WindowNumbers StatesOf(const Window& window, const VertexList& vertices) {
  WindowNumbers numbers;
  const auto place = [&](const auto& vertex) { return PlaceOf(vertex.get(), vertices); };
  numbers.extrinsic = place(window.extrinsic);
  numbers.time_offset = place(window.time_offset);
  for (const WindowFrame& frame : window.frames) {
    numbers.frames.push_back(
        {frame.id, frame.t, place(frame.pose), place(frame.speed_bias), NumbersOf(frame.imu.get())});
  }
  for (const auto& [track, landmark] : window.landmarks) {
    numbers.landmarks.push_back({track, place(landmark.inverse_depth), landmark.seen});
  }
  numbers.has_prior = window.prior != nullptr;
  return numbers;
}

WindowNumbers NumbersOf(const Window& window) {
  const VertexList vertices = VerticesOf(window);
  WindowNumbers numbers = StatesOf(window, vertices);
  const EdgeList& edges = window.graph.Edges();
  numbers.graph = NumbersOf(vertices, edges);
  if (!window.prior) return numbers;
  numbers.prior = NumbersOf(window.prior->GetPrior(), vertices);
  const auto at = std::find(edges.begin(), edges.end(), window.prior);
  if (at != edges.end()) numbers.prior_edge = static_cast<int>(at - edges.begin());
  return numbers;
}

// ---- from numbers ----------------------------------------------------------------------------------------------------

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

void SetStates(const WindowNumbers& numbers, const VertexList& vertices, Window* window) {
  std::vector<WindowFrame> frames;
  for (const FrameNumbers& one : numbers.frames) {
    WindowFrame& frame = frames.emplace_back();
    frame.id = one.id;
    frame.t = one.t;
    frame.pose = VertexAt<VertexPose>(one.pose, vertices);
    frame.speed_bias = VertexAt<VertexSpeedBias>(one.speed_bias, vertices);
    if (!frame.pose || !frame.speed_bias) throw WireError("a frame without pose, or without speed and biases");
    frame.imu = MakeImu(one.imu, *window);
  }
  window->frames = std::move(frames);
  window->landmarks.clear();
  for (const LandmarkNumbers& one : numbers.landmarks) {
    WindowLandmark& landmark = window->landmarks[one.track];
    landmark.seen = one.seen;
    landmark.inverse_depth = VertexAt<VertexInverseDepth>(one.inverse_depth, vertices);
  }
}

WireWindow::WireWindow(const WindowNumbers& numbers) : vertices(MakeVertices(numbers.graph.vertices)) {
  SetStates(numbers, vertices, &window);
  window.extrinsic = VertexAt<VertexPose>(numbers.extrinsic, vertices);
  window.time_offset = VertexAt<VertexScalar>(numbers.time_offset, vertices);
  if (numbers.has_prior) window.prior = std::make_shared<EdgePrior>(MakePrior(numbers.prior, vertices, nullptr));
  for (size_t k = 0; k < vertices.size(); ++k) {
    if (numbers.graph.vertices[k].id >= 0) window.graph.AddVertex(vertices[k], numbers.graph.vertices[k].id);
  }
  for (const EdgeNumbers& one : numbers.graph.edges) {
    const bool is_prior = static_cast<int>(edges.size()) == numbers.prior_edge;
    edges.push_back(is_prior ? std::shared_ptr<Edge>(window.prior) : std::make_shared<WireEdge>(one, vertices));
    window.graph.AddEdge(edges.back(), one.id);
  }
}

}  // namespace ch5::homework
