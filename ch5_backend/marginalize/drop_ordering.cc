#include "ch5_backend/marginalize/drop_ordering.h"

#include <algorithm>

namespace ch5 {
namespace {

using Edges = std::vector<std::shared_ptr<Edge>>;
using Vertices = std::vector<std::shared_ptr<Vertex>>;

// Until the vertices are numbered, their OrderingIds say what is known of them.
constexpr int kFixed = -1, kKept = -2, kDropped = -3, kListed = 0;

// The free vertices of the edges by what becomes of them; each by id (vertices outside of a graph keep their order).
void SortVertices(const Edges& edges, const Vertices& drop, Vertices* kept, Vertices* dropped, Vertices* landmarks) {
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) vertex->SetOrderingId(vertex->IsFixed() ? kFixed : kKept);
  }
  for (const auto& vertex : drop) vertex->SetOrderingId(vertex->IsFixed() ? kFixed : kDropped);
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) {
      const int state = vertex->OrderingId();
      if (state == kFixed || state == kListed) continue;
      const bool is_landmark = state == kDropped && vertex->GetRole() == Role::kLandmark;
      (is_landmark ? landmarks : state == kDropped ? dropped : kept)->push_back(vertex);
      vertex->SetOrderingId(kListed);
    }
  }
  for (Vertices* vertices : {kept, dropped, landmarks}) {
    std::stable_sort(vertices->begin(), vertices->end(),
                     [](const auto& a, const auto& b) { return a->Id() < b->Id(); });
  }
}

// OrderingIds are the vertices' numbers meanwhile.
Incidence FindIncidence(const Edges& edges) {
  Incidence incidence;
  incidence.begin.reserve(edges.size() + 1);
  for (const auto& edge : edges) {
    incidence.max_residual_dimension = std::max(incidence.max_residual_dimension, edge->ResidualDimension());
    const auto& vertices = edge->Vertices();
    for (int i = 0; i < static_cast<int>(vertices.size()); ++i) {
      if (vertices[i]->OrderingId() != kFixed) incidence.entries.push_back({i, vertices[i]->OrderingId()});
    }
    incidence.begin.push_back(static_cast<int>(incidence.entries.size()));
  }
  return incidence;
}

}  // namespace

Vertices FixedOrAtEdges(Vertices vertices, const Edges& edges) {
  constexpr int kMissing = -2, kThere = -1;
  for (const auto& vertex : vertices) vertex->SetOrderingId(vertex->IsFixed() ? kThere : kMissing);
  for (const auto& edge : edges) {
    for (const auto& vertex : edge->Vertices()) vertex->SetOrderingId(kThere);
  }
  const auto is_missing = [](const auto& vertex) { return vertex->OrderingId() == kMissing; };
  vertices.erase(std::remove_if(vertices.begin(), vertices.end(), is_missing), vertices.end());
  return vertices;
}

DropOrdering MakeDropOrdering(const Edges& edges, const Vertices& drop) {
  DropOrdering found;
  Ordering& ordering = found.ordering;
  Vertices dropped;
  SortVertices(edges, drop, &ordering.poses, &dropped, &ordering.landmarks);
  found.num_kept = static_cast<int>(ordering.poses.size());
  for (const auto& vertex : ordering.poses) found.kept_size += vertex->LocalDimension();
  ordering.poses.insert(ordering.poses.end(), dropped.begin(), dropped.end());

  int number = 0;
  for (const Vertices* vertices : {&ordering.poses, &ordering.landmarks}) {
    for (const auto& vertex : *vertices) vertex->SetOrderingId(number++);
  }
  ordering.edges = edges;
  ordering.incidence = FindIncidence(edges);
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
