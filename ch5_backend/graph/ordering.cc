#include "ch5_backend/graph/ordering.h"

#include <algorithm>
#include <string>
#include <unordered_set>

namespace ch5 {
namespace {

std::vector<std::shared_ptr<Edge>> SelectedEdges(const Graph& graph, const Selection& selection) {
  std::unordered_set<const Vertex*> chosen;
  for (const auto& vertex : selection.vertices) chosen.insert(vertex.get());
  const auto is_chosen = [&](const std::shared_ptr<Vertex>& vertex) { return chosen.count(vertex.get()) > 0; };
  std::vector<std::shared_ptr<Edge>> edges;
  edges.reserve(graph.Edges().size());
  for (const auto& edge : graph.Edges()) {
    if (selection.level >= 0 && edge->Level() != selection.level) continue;
    const auto& vertices = edge->Vertices();
    if (selection.all_vertices || std::all_of(vertices.begin(), vertices.end(), is_chosen)) edges.push_back(edge);
  }
  return edges;
}

}  // namespace

Ordering MakeOrdering(const Graph& graph, const Selection& selection) {
  Ordering ordering;
  ordering.edges = SelectedEdges(graph, selection);
  constexpr int kSeen = 0, kUnseen = -1;
  for (const auto& vertex : graph.Vertices()) vertex->SetOrderingId(kUnseen);
  for (const auto& edge : ordering.edges) {
    for (const auto& vertex : edge->Vertices()) vertex->SetOrderingId(vertex->IsFixed() ? kUnseen : kSeen);
  }

  for (const auto& vertex : graph.Vertices()) {
    if (vertex->OrderingId() == kUnseen) continue;
    const bool is_pose = vertex->GetRole() == Role::kPose;
    (is_pose ? ordering.poses : ordering.landmarks).push_back(vertex);
  }
  for (const auto& vertex : ordering.poses) {
    vertex->SetOrderingId(ordering.dim_poses);
    ordering.dim_poses += vertex->LocalDimension();
  }
  for (const auto& vertex : ordering.landmarks) {
    vertex->SetOrderingId(ordering.dim_poses + ordering.dim_landmarks);
    ordering.dim_landmarks += vertex->LocalDimension();
  }
  return ordering;
}

int FreeLandmarkOf(const Edge& edge) {
  const auto& vertices = edge.Vertices();
  int found = -1;
  for (size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i]->OrderingId() < 0 || vertices[i]->GetRole() != Role::kLandmark) continue;
    if (found >= 0) {
      const auto name = [](const Vertex& vertex) { return vertex.TypeInfo() + " " + std::to_string(vertex.Id()); };
      throw GraphError(edge.TypeInfo() + " " + std::to_string(edge.Id()) + " ties two free landmarks, " +
                       name(*vertices[found]) + " and " + name(*vertices[i]) + "; give one of them the role of a pose");
    }
    found = static_cast<int>(i);
  }
  return found;
}

}  // namespace ch5
