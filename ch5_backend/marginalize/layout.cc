#include "ch5_backend/marginalize/layout.h"

#include <algorithm>
#include <stdexcept>
#include <unordered_set>

namespace ch5 {
namespace {

// By id, and those outside of a graph as they come: the result must not depend on addresses.
void SortById(std::vector<std::shared_ptr<Vertex>>* vertices) {
  std::stable_sort(vertices->begin(), vertices->end(), [](const auto& a, const auto& b) { return a->Id() < b->Id(); });
}

}  // namespace

Layout MakeLayout(const std::vector<std::shared_ptr<Edge>>& edges, const std::vector<std::shared_ptr<Vertex>>& drop) {
  Layout layout;
  std::unordered_set<const Vertex*> dropped, seen;
  for (const auto& vertex : drop) dropped.insert(vertex.get());
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) {
      if (vertex->IsFixed() || !seen.insert(vertex.get()).second) continue;
      const bool goes = dropped.count(vertex.get()) > 0;
      const bool is_landmark = goes && vertex->GetRole() == Role::kLandmark;
      (is_landmark ? layout.landmarks : goes ? layout.dropped : layout.kept).push_back(vertex);
    }
  }
  for (auto* vertices : {&layout.kept, &layout.dropped, &layout.landmarks}) SortById(vertices);
  for (const auto* vertices : {&layout.kept, &layout.dropped}) {
    for (const auto& vertex : *vertices) {
      layout.column.emplace(vertex.get(), layout.size);
      layout.size += vertex->LocalDimension();
    }
    if (vertices == &layout.kept) layout.kept_size = layout.size;
  }
  for (const auto& vertex : layout.landmarks) layout.landmark.emplace(vertex.get(), layout.landmark.size());

  layout.landmark_edges.resize(layout.landmarks.size());
  for (const auto& edge : edges) {
    int owner = -1;
    for (const auto& vertex : edge->Vertices()) {
      const auto it = layout.landmark.find(vertex.get());
      if (it == layout.landmark.end()) continue;
      if (owner >= 0) throw std::invalid_argument("Marginalize: " + edge->TypeInfo() + " ties two dropped landmarks");
      owner = it->second;
    }
    (owner < 0 ? layout.dense_edges : layout.landmark_edges[static_cast<size_t>(owner)]).push_back(edge.get());
  }
  return layout;
}

}  // namespace ch5
