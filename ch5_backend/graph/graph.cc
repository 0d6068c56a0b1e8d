#include "ch5_backend/graph/graph.h"

#include <algorithm>
#include <string>

namespace ch5 {
namespace {

// Ids ascend with position, so a member is found by bisection.
template <typename T>
typename std::vector<std::shared_ptr<T>>::const_iterator Find(const std::vector<std::shared_ptr<T>>& items,
                                                              const T& item) {
  const auto it = std::lower_bound(items.begin(), items.end(), item.Id(),
                                   [](const std::shared_ptr<T>& member, int id) { return member->Id() < id; });
  return it != items.end() && it->get() == &item ? it : items.end();
}

std::string Name(const Vertex& vertex) {
  return vertex.TypeInfo() + (vertex.Id() < 0 ? "" : " " + std::to_string(vertex.Id()));
}

}  // namespace

int Graph::AddVertex(std::shared_ptr<Vertex> vertex) {
  if (!vertex) throw GraphError("AddVertex: the vertex is null");
  if (vertex->Id() >= 0) throw GraphError("AddVertex: " + Name(*vertex) + " is already in a graph");
  if (!vertex->Parameters().allFinite()) {
    throw GraphError("AddVertex: " + Name(*vertex) + " holds a number that is not finite");
  }
  vertex->id_ = next_vertex_id_++;
  vertices_.push_back(std::move(vertex));
  return vertices_.back()->Id();
}

int Graph::AddEdge(std::shared_ptr<Edge> edge) {
  if (!edge) throw GraphError("AddEdge: the edge is null");
  const std::string name = edge->TypeInfo();
  if (edge->Id() >= 0)
    throw GraphError("AddEdge: " + name + " " + std::to_string(edge->Id()) + " is already in a graph");
  const auto& vertices = edge->Vertices();
  for (size_t i = 0; i < vertices.size(); ++i) {
    const std::string place = "AddEdge: " + name + ", vertex " + std::to_string(i) + ": ";
    if (!vertices[i]) throw GraphError(place + "missing (null)");
    if (!Contains(*vertices[i])) throw GraphError(place + Name(*vertices[i]) + " is not in this graph");
    if (std::find(vertices.begin(), vertices.begin() + static_cast<long>(i), vertices[i]) !=
        vertices.begin() + static_cast<long>(i)) {
      throw GraphError(place + Name(*vertices[i]) + " is repeated");
    }
  }
  edge->id_ = next_edge_id_++;
  edges_.push_back(std::move(edge));
  return edges_.back()->Id();
}

void Graph::RemoveEdge(const std::shared_ptr<Edge>& edge) {
  if (!edge || !Contains(*edge)) throw GraphError("RemoveEdge: the edge is not in this graph");
  const auto it = Find<Edge>(edges_, *edge);
  (*it)->id_ = -1;
  edges_.erase(it);
}

void Graph::RemoveVertex(const std::shared_ptr<Vertex>& vertex) {
  if (!vertex || !Contains(*vertex)) throw GraphError("RemoveVertex: the vertex is not in this graph");
  for (const auto& edge : EdgesOf(*vertex)) RemoveEdge(edge);
  const auto it = Find<Vertex>(vertices_, *vertex);
  (*it)->id_ = -1;
  (*it)->ordering_id_ = -1;
  vertices_.erase(it);
}

std::vector<std::shared_ptr<Edge>> Graph::EdgesOf(const Vertex& vertex) const {
  std::vector<std::shared_ptr<Edge>> edges;
  for (const auto& edge : edges_) {
    const auto& vertices = edge->Vertices();
    const auto is_it = [&](const std::shared_ptr<Vertex>& v) { return v.get() == &vertex; };
    if (std::any_of(vertices.begin(), vertices.end(), is_it)) edges.push_back(edge);
  }
  return edges;
}

bool Graph::Contains(const Vertex& vertex) const { return Find(vertices_, vertex) != vertices_.end(); }
bool Graph::Contains(const Edge& edge) const { return Find(edges_, edge) != edges_.end(); }

double ComputeCost(const Graph& graph) {
  double sum = 0.0;
  for (const auto& edge : graph.Edges()) {
    edge->ComputeResidual();
    sum += edge->RobustChi2();
  }
  return 0.5 * sum;
}

}  // namespace ch5
