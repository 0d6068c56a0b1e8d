#include "ch5_backend/graph/ordering.h"

#include <cmath>

#include <algorithm>
#include <unordered_set>

namespace ch5 {
namespace {

constexpr int kNone = -1;

class Selected {
 public:
  explicit Selected(const Selection& selection) : selection_(selection) {
    for (const auto& vertex : selection.vertices) chosen_.insert(vertex.get());
  }
  bool operator()(const Edge& edge) const {
    if (selection_.level >= 0 && edge.Level() != selection_.level) return false;
    const auto& vertices = edge.Vertices();
    return selection_.all_vertices || std::all_of(vertices.begin(), vertices.end(),
                                                  [&](const auto& vertex) { return chosen_.count(vertex.get()) > 0; });
  }

 private:
  const Selection& selection_;
  std::unordered_set<const Vertex*> chosen_;
};

// Prefetches what is needed soon: edges and vertices are scattered in memory.
template <typename T>
void PrefetchSoon(const std::vector<std::shared_ptr<T>>& items, size_t k) {
  constexpr size_t kSoon = 16;
  if (k + kSoon < items.size()) __builtin_prefetch(items[k + kSoon].get());
}

// The same, and the vertices of edges that are needed sooner.
void Prefetch(const std::vector<std::shared_ptr<Edge>>& edges, size_t e) {
  constexpr size_t kSooner = 8;
  PrefetchSoon(edges, e);
  if (e + kSooner >= edges.size()) return;
  for (const auto& vertex : edges[e + kSooner]->Vertices()) __builtin_prefetch(vertex.get());
}

// The only loop over the edges. Until MakeOrdering replaces them, OrderingIds and numbers are positions in the graph.
void ListEdges(const Graph& graph, const Selection& selection, Ordering* ordering) {
  Incidence& incidence = ordering->incidence;
  ordering->edges.reserve(graph.Edges().size());
  incidence.begin.reserve(graph.Edges().size() + 1);
  incidence.entries.reserve(2 * graph.Edges().size());
  const Selected is_selected(selection);
  for (size_t e = 0; e < graph.Edges().size(); ++e) {
    const auto& edge = graph.Edges()[e];
    Prefetch(graph.Edges(), e);
    if (!is_selected(*edge)) continue;
    ordering->edges.push_back(edge);
    incidence.Append(*edge);
  }
}

}  // namespace

Ordering MakeOrdering(const Graph& graph, const Selection& selection, Ordering used) {
  Ordering ordering = std::move(used);
  ordering.Clear();
  const auto& vertices = graph.Vertices();
  for (size_t k = 0; k < vertices.size(); ++k) {
    vertices[k]->SetOrderingId(vertices[k]->IsFixed() ? kNone : static_cast<int>(k));
  }
  ListEdges(graph, selection, &ordering);

  constexpr int kSeen = 0;
  Array<int> number(vertices.size(), kNone);  // of the vertex at each position
  for (const auto& entry : ordering.incidence.entries) number[entry.number] = kSeen;
  int next = 0;
  for (auto* list : {&ordering.poses, &ordering.landmarks}) list->reserve(vertices.size());
  for (const Role role : {Role::kPose, Role::kLandmark}) {
    const bool is_pose = role == Role::kPose;
    for (size_t k = 0; k < vertices.size(); ++k) {
      Vertex& vertex = *vertices[k];
      if (vertex.GetRole() != role) continue;
      vertex.SetOrderingId(number[k] == kNone ? kNone : ordering.Size());
      if (number[k] == kNone) continue;
      number[k] = next++;
      (is_pose ? ordering.poses : ordering.landmarks).push_back(vertices[k]);
      (is_pose ? ordering.dim_poses : ordering.dim_landmarks) += vertex.LocalDimension();
    }
  }
  for (auto& entry : ordering.incidence.entries) entry.number = number[entry.number];
  return ordering;
}

Array<int> LandmarkOfEachEdge(const Ordering& ordering) {
  const Incidence& incidence = ordering.incidence;
  const int num_poses = static_cast<int>(ordering.poses.size());
  Array<int> landmarks(ordering.edges.size(), kNone);
  for (size_t e = 0; e < landmarks.size(); ++e) {
    for (int k = incidence.begin[e]; k < incidence.begin[e + 1]; ++k) {
      const int landmark = incidence.entries[k].number - num_poses;
      if (landmark < 0) continue;
      if (landmarks[e] != kNone) {
        throw GraphError(ordering.edges[e]->Name() + " ties two free landmarks, " +
                         ordering.landmarks[landmarks[e]]->Name() + " and " + ordering.landmarks[landmark]->Name() +
                         "; give one of them the role of a pose");
      }
      landmarks[e] = landmark;
    }
  }
  return landmarks;
}

void CheckOrdering(const Ordering& ordering) {
  const std::string reason = " while it was being solved; a callback must leave the graph as it is";
  int row = 0;
  for (const auto* vertices : {&ordering.poses, &ordering.landmarks}) {
    for (const auto& vertex : *vertices) {
      PrefetchSoon(*vertices, &vertex - vertices->data());
      if (vertex->Id() < 0) throw GraphError(vertex->TypeInfo() + " has left the graph" + reason);
      if (vertex->OrderingId() != row) throw GraphError(vertex->Name() + " has been numbered anew" + reason);
      row += vertex->LocalDimension();
    }
  }
  for (const auto& edge : ordering.edges) {
    PrefetchSoon(ordering.edges, &edge - ordering.edges.data());
    if (edge->Id() < 0) throw GraphError(edge->TypeInfo() + " has left the graph" + reason);
  }
}

void Update(const Ordering& ordering, const VecX& delta_x) {
  for (const auto* vertices : {&ordering.poses, &ordering.landmarks}) {
    for (const auto& vertex : *vertices) {
      vertex->BackUpParameters();
      vertex->Plus(delta_x.data() + vertex->OrderingId());
    }
  }
}

void RollBack(const Ordering& ordering) {
  for (const auto& vertex : ordering.poses) vertex->RollBackParameters();
  for (const auto& vertex : ordering.landmarks) vertex->RollBackParameters();
}

double StateNorm(const Ordering& ordering) {
  double sum = 0.0;
  for (const auto& vertex : ordering.poses) sum += vertex->Parameters().squaredNorm();
  for (const auto& vertex : ordering.landmarks) sum += vertex->Parameters().squaredNorm();
  return std::sqrt(sum);
}

std::string WhatIsNotFinite(const std::vector<std::shared_ptr<Edge>>& edges) {
  for (const auto& edge : edges) {
    edge->Linearize();
    bool is_finite = edge->Residual().allFinite();
    for (size_t i = 0; i < edge->Vertices().size(); ++i) is_finite = is_finite && edge->Jacobian(i).allFinite();
    if (!is_finite) return edge->Name() + " has a residual or a Jacobian that is not finite";
    if (!std::isfinite(edge->Cost())) return edge->Name() + " has a cost that is not finite, by its loss or its size";
  }
  return "";
}

}  // namespace ch5
