/// Stage 6 in the worker, the window's functions; those of MarginalizationInfo are in remote_vins_term.cc.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/remote/window_wire.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

// What the student's function names and the window does not have.
std::shared_ptr<Vertex> ForeignVertex() { return std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0)); }
std::shared_ptr<Edge> ForeignEdge() {
  return std::make_shared<WireEdge>(EdgeNumbers{"Edge", -1, 0, {}, {}, 0.0, {}, {}}, VertexList{});
}

template <typename T>
std::shared_ptr<T> At(int place, const std::vector<std::shared_ptr<T>>& list, std::shared_ptr<T> (*foreign)()) {
  if (place == kNull) return nullptr;
  const auto index = static_cast<size_t>(place);
  return index < list.size() ? list[index] : foreign();
}

DropSet AskForDropSet(const std::string& function, const Window& window) {
  std::vector<int> edges, vertices;
  Ask(function, Pack(NumbersOf(window)), &edges, &vertices);
  const VertexList all = VerticesOf(window);
  DropSet drop;
  for (const int place : edges) drop.edges.push_back(At(place, window.graph.Edges(), &ForeignEdge));
  for (const int place : vertices) drop.vertices.push_back(At(place, all, &ForeignVertex));
  return drop;
}

DropSet RemoteMarginOld(const Window& window) { return AskForDropSet("DropSetOfMarginOld", window); }
DropSet RemoteMarginSecondNew(const Window& window) { return AskForDropSet("DropSetOfMarginSecondNew", window); }

// The window's own vertices take the numbers that come back; those behind them are new.
void Take(const WindowNumbers& after, Window* window) {
  VertexList vertices = VerticesOf(*window);
  const auto& numbers = after.graph.vertices;
  if (numbers.size() < vertices.size()) throw WireError("vertices are missing");
  for (const VertexNumbers& one : numbers) {
    if (!one.x.allFinite()) throw WireError("a vertex holds a number that is not finite");
  }
  for (size_t k = 0; k < vertices.size(); ++k) SetVertex(numbers[k], vertices[k].get());
  for (size_t k = vertices.size(); k < numbers.size(); ++k) vertices.push_back(MakeVertex(numbers[k]));
  SetStates(after, vertices, window);
  if (!after.has_prior) window->prior = nullptr;
}

void RemoteSlide(MarginalizationFlag flag, Window* window) {
  WindowNumbers after;
  Ask("SlideWindow", Pack(NumbersOf(*window), flag), &after);
  try {
    Take(after, window);
  } catch (const std::invalid_argument& error) {
    throw WorkerFailure(std::string("GARBAGE in the reply to SlideWindow: ") + error.what());
  } catch (const WireError& error) {
    throw WorkerFailure(std::string("GARBAGE in the reply to SlideWindow: ") + error.what());
  }
}

Failure RemoteDetectFailure(const Window& window, const Vec3& last_p) {
  Failure failure;
  Ask("DetectFailure", Pack(NumbersOf(window), last_p), &failure);
  return failure;
}

[[maybe_unused]] const bool added = [] {
  Linked()->vins_window = {&RemoteMarginOld, &RemoteMarginSecondNew, &RemoteSlide, &RemoteDetectFailure};
  return true;
}();

}  // namespace
}  // namespace ch5::homework
