/// Stage 6, the window's functions; those of MarginalizationInfo are in worker_vins_term.cc.

#include <algorithm>

#include "ch5_homework/judge/remote/window_wire.h"
#include "ch5_homework/judge/remote/worker.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

// The places of what is dropped.
void WriteDropSet(const DropSet& drop, const WireWindow& wire, Writer* out) {
  std::vector<int> edges, vertices;
  for (const auto& edge : drop.edges) {
    const auto at = std::find(wire.edges.begin(), wire.edges.end(), edge);
    edges.push_back(edge == nullptr          ? kNull
                    : at == wire.edges.end() ? kUnknown
                                             : static_cast<int>(at - wire.edges.begin()));
  }
  for (const auto& vertex : drop.vertices) vertices.push_back(PlaceOf(vertex.get(), wire.vertices));
  *out << edges << vertices;
}

void MarginOld(Reader* in, Writer* out) {
  WindowNumbers numbers;
  *in >> numbers;
  const WireWindow wire(numbers);
  WriteDropSet(Chosen().vins_window.margin_old(wire.window), wire, out);
}

void MarginSecondNew(Reader* in, Writer* out) {
  WindowNumbers numbers;
  *in >> numbers;
  const WireWindow wire(numbers);
  WriteDropSet(Chosen().vins_window.margin_second_new(wire.window), wire, out);
}

void Slide(Reader* in, Writer* out) {
  WindowNumbers numbers;
  MarginalizationFlag flag;
  Unpack(in, &numbers, &flag);
  WireWindow wire(numbers);
  Chosen().vins_window.slide(flag, &wire.window);
  const VertexList vertices = VerticesOf(wire.window, wire.vertices);
  WindowNumbers after = StatesOf(wire.window, vertices);
  after.graph.vertices = NumbersOf(vertices);
  *out << after;
}

void DetectFailure(Reader* in, Writer* out) {
  WindowNumbers numbers;
  Vec3 last_p;
  Unpack(in, &numbers, &last_p);
  const WireWindow wire(numbers);
  *out << Chosen().vins_window.detect_failure(wire.window, last_p);
}

[[maybe_unused]] const bool added = Handle("DropSetOfMarginOld", &MarginOld) &&
                                    Handle("DropSetOfMarginSecondNew", &MarginSecondNew) &&
                                    Handle("SlideWindow", &Slide) && Handle("DetectFailure", &DetectFailure);

}  // namespace
}  // namespace ch5::homework
