#pragma once
/// The right drop sets of stage 6's windows, found in another way than the homework's.

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "ch5_backend/window/vins_window.h"
#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/diagnosis.h"
#include "ch5_homework/judge/scenes/windows.h"

namespace ch5::homework {

inline bool Holds(const std::vector<std::shared_ptr<Vertex>>& vertices, const std::shared_ptr<Vertex>& vertex) {
  return std::find(vertices.begin(), vertices.end(), vertex) != vertices.end();
}

/// What a student's function has named and the scene does not have.
class ForeignEdge : public Edge {
 public:
  ForeignEdge() : Edge(0, {}, nullptr, nullptr) {}
  void ComputeResidual() override {}
  void ComputeJacobians() override {}
  std::string TypeInfo() const override { return "Edge"; }
};

/// The items at these places: null for −1, `foreign` where the list has none.
template <typename T>
std::vector<std::shared_ptr<T>> At(const VecX& places, const std::vector<std::shared_ptr<T>>& list,
                                   const std::shared_ptr<T>& foreign) {
  std::vector<std::shared_ptr<T>> items;
  for (const double place : places) {
    const bool known = place >= 0.0 && place < static_cast<double>(list.size());
    items.push_back(known ? list[static_cast<size_t>(place)] : place == -1.0 ? nullptr : foreign);
  }
  return items;
}

/// A drop set of the submission's.  @param number  behind the names of its places
inline DropSet DropSetIn(const Answer& answer, WindowScene* scene, const std::string& number = "") {
  const std::shared_ptr<Vertex> vertex = std::make_shared<VertexScalar>(VertexScalar::Estimate(0.0));
  return {At<Edge>(answer.Vector("edges" + number), scene->Edges(), std::make_shared<ForeignEdge>()),
          At<Vertex>(answer.Vector("vertices" + number), scene->Vertices(), vertex)};
}
inline DropSet AskForDropSet(WindowScene* scene, MarginalizationFlag flag) {
  return DropSetIn(Ask("DropSet", *scene, {{"flag", flag}}), scene);
}

/// How many edges of each type, and how many vertices of each.
inline Text Inventory(const DropSet& drop) {
  std::map<std::string, int> edges, vertices;
  for (const auto& edge : drop.edges) ++edges[edge ? edge->TypeInfo() : "null"];
  for (const auto& vertex : drop.vertices) ++vertices[vertex ? vertex->TypeInfo() : "null"];
  const auto list = [](const std::map<std::string, int>& counts, const char* none) {
    std::string text;
    for (const auto& [type, count] : counts) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + type;
    return counts.empty() ? Text(none) : Word(text);
  };
  return {"6.inventory", {{"vertices", list(vertices, "6.no_vertex")}, {"edges", list(edges, "6.no_edge")}}};
}

/// Of any edge of a kind: "EdgeReprojection" is EdgeReprojectionCalibration too.
inline bool Is(const std::shared_ptr<Edge>& edge, const std::string& kind) {
  return edge && edge->TypeInfo().compare(0, kind.size(), kind) == 0;
}
inline int Count(const DropSet& drop, const std::string& kind) {
  return static_cast<int>(
      std::count_if(drop.edges.begin(), drop.edges.end(), [&](const auto& edge) { return Is(edge, kind); }));
}

/// The same edges, and the same vertices among theirs; vertices without any of these edges count for nothing.
inline bool Same(const DropSet& a, const DropSet& b) {
  const auto edges = [](const DropSet& drop) {
    std::vector<int> ids;
    for (const auto& edge : drop.edges) ids.push_back(edge ? edge->Id() : -1);
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  const auto vertices = [](const DropSet& drop) {
    std::vector<int> ids;
    for (const auto& vertex : drop.vertices) {
      const bool used = !vertex || std::any_of(drop.edges.begin(), drop.edges.end(), [&](const auto& edge) {
        return edge && Holds(edge->Vertices(), vertex);
      });
      if (used) ids.push_back(vertex ? vertex->Id() : -1);
    }
    std::sort(ids.begin(), ids.end());
    return ids;
  };
  return edges(a) == edges(b) && vertices(a) == vertices(b);
}

inline DropSet RightMarginOld(const Window& window) {
  DropSet drop;
  drop.vertices = {window.frames[0].pose, window.frames[0].speed_bias};
  for (const auto& edge : window.graph.Edges()) {
    const auto& held = edge->Vertices();
    if (Holds(held, window.frames[0].pose) || Holds(held, window.frames[0].speed_bias)) drop.edges.push_back(edge);
    if (Is(edge, "EdgeReprojection") && held[1] == window.frames[0].pose && !Holds(drop.vertices, held[0])) {
      drop.vertices.push_back(held[0]);
    }
  }
  return drop;
}

}  // namespace ch5::homework
