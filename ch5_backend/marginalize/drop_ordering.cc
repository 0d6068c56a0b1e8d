#include "ch5_backend/marginalize/drop_ordering.h"

#include <algorithm>
#include <stdexcept>

namespace ch5 {
namespace {

using Edges = std::vector<std::shared_ptr<Edge>>;
using Vertices = std::vector<std::shared_ptr<Vertex>>;
using VertexArray = Array<std::shared_ptr<Vertex>>;

// Until the vertices are numbered, their OrderingIds say what is known of them; those listed have 0, 1, ….
constexpr int kFixed = -1, kKept = -2, kDropped = -3;

// The free vertices of the edges by what becomes of them; each by id (vertices outside of a graph keep their order).
void SortVertices(const Edges& edges, const Vertices& drop, VertexArray* kept, VertexArray* dropped,
                  VertexArray* landmarks) {
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) vertex->SetOrderingId(vertex->IsFixed() ? kFixed : kKept);
  }
  for (const auto& vertex : drop) vertex->SetOrderingId(vertex->IsFixed() ? kFixed : kDropped);
  int listed = 0;
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) {
      const int state = vertex->OrderingId();
      if (state == kFixed || state >= 0) continue;
      const bool is_landmark = state == kDropped && vertex->GetRole() == Role::kLandmark;
      (is_landmark ? landmarks : state == kDropped ? dropped : kept)->push_back(vertex);
      vertex->SetOrderingId(listed++);
    }
  }
  for (VertexArray* vertices : {kept, dropped, landmarks}) {
    std::sort(vertices->begin(), vertices->end(), [](const auto& a, const auto& b) {
      return std::pair(a->Id(), a->OrderingId()) < std::pair(b->Id(), b->OrderingId());
    });
  }
}

// By their OrderingIds: those of the vertices that are neither fixed nor at one of the edges.
constexpr int kMissing = -2, kThere = -1;
bool IsMissing(const std::shared_ptr<Vertex>& vertex) { return vertex->OrderingId() == kMissing; }
void MarkMissing(const Vertices& vertices, const Edges& edges) {
  for (const auto& vertex : vertices) vertex->SetOrderingId(vertex->IsFixed() ? kThere : kMissing);
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) vertex->SetOrderingId(kThere);
  }
}

// An edge listed twice would count twice.
void CheckEdges(const Edges& edges) {
  if (edges.empty()) throw std::invalid_argument("Marginalize: no edges, so there is nothing to be known of the rest");
  Array<const Edge*> sorted;
  sorted.reserve(edges.size());
  for (const auto& edge : edges) {
    if (!edge) throw std::invalid_argument("Marginalize: an edge is null");
    sorted.push_back(edge.get());
  }
  // Where ids ascend, as a graph lists its edges, none is listed twice; those outside of a graph are all −1.
  const auto not_ascending = [](const Edge* a, const Edge* b) { return a->Id() >= b->Id(); };
  if (std::adjacent_find(sorted.begin(), sorted.end(), not_ascending) == sorted.end()) return;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end())
    throw std::invalid_argument("Marginalize: " + (*twice)->Name() + " stands twice in the edges");
}

// A vertex that is not there would stay in the problem, and what is known of it with it.
void CheckDropped(const Vertices& drop, const Edges& edges) {
  for (const auto& vertex : drop) {
    if (!vertex) throw std::invalid_argument("Marginalize: a vertex to drop is null");
  }
  MarkMissing(drop, edges);
  const auto missing = std::find_if(drop.begin(), drop.end(), IsMissing);
  if (missing == drop.end()) return;
  throw std::invalid_argument("Marginalize: " + (*missing)->Name() + " is to be dropped, but none of the edges has it");
}

}  // namespace

void CheckMarginalization(const Edges& edges, const Vertices& drop) {
  CheckEdges(edges);
  CheckDropped(drop, edges);
}

Vertices FixedOrAtEdges(Vertices vertices, const Edges& edges) {
  MarkMissing(vertices, edges);
  vertices.erase(std::remove_if(vertices.begin(), vertices.end(), IsMissing), vertices.end());
  return vertices;
}

DropOrdering MakeDropOrdering(const Edges& edges, const Vertices& drop) {
  DropOrdering found;
  Ordering& ordering = found.ordering;
  VertexArray kept, dropped, landmarks;
  SortVertices(edges, drop, &kept, &dropped, &landmarks);
  found.num_kept = static_cast<int>(kept.size());
  for (const auto& vertex : kept) found.kept_size += vertex->LocalDimension();
  kept.insert(kept.end(), dropped.begin(), dropped.end());
  ordering.poses.assign(kept.begin(), kept.end());
  ordering.landmarks.assign(landmarks.begin(), landmarks.end());

  int number = 0;
  for (const Vertices* vertices : {&ordering.poses, &ordering.landmarks}) {
    for (const auto& vertex : *vertices) vertex->SetOrderingId(number++);
  }
  ordering.edges = edges;
  ordering.incidence.begin.reserve(edges.size() + 1);
  for (const auto& edge : edges) ordering.incidence.Append(*edge);
  for (const auto& vertex : ordering.poses) {
    vertex->SetOrderingId(ordering.dim_poses);
    ordering.dim_poses += vertex->LocalDimension();
  }
  for (const auto& vertex : ordering.landmarks) {
    vertex->SetOrderingId(ordering.Size());
    ordering.dim_landmarks += vertex->LocalDimension();
  }
  return found;
}

}  // namespace ch5
