#include "ch5_backend/graph/graph.h"

#include <algorithm>
#include <limits>
#include <string>

namespace ch5 {
namespace {

template <typename T>
using Iterator = typename std::vector<std::shared_ptr<T>>::const_iterator;

// Ids ascend with position, so a member is found by bisection. It is never behind the position `id`, and mostly there.
template <typename T>
Iterator<T> LowerBound(const std::vector<std::shared_ptr<T>>& items, int id) {
  if (items.empty() || items.back()->Id() < id) return items.end();
  const auto last = items.begin() + std::clamp(id, 0, static_cast<int>(items.size()) - 1);
  if ((*last)->Id() == id) return last;
  return std::lower_bound(items.begin(), last, id,
                          [](const std::shared_ptr<T>& member, int wanted) { return member->Id() < wanted; });
}

template <typename T>
Iterator<T> Find(const std::vector<std::shared_ptr<T>>& items, const T& item) {
  const auto it = LowerBound(items, item.Id());
  return it != items.end() && it->get() == &item ? it : items.end();
}

}  // namespace

Graph::~Graph() { Clear(); }

void Graph::Clear() {
  for (const auto& edge : edges_) edge->id_ = -1;
  for (const auto& vertex : vertices_) vertex->id_ = vertex->ordering_id_ = -1;
  edges_.clear();
  vertices_.clear();
  stack_.clear();
  next_vertex_id_ = next_edge_id_ = 0;
}

void Graph::Swap(Graph* other) noexcept {
  vertices_.swap(other->vertices_);
  edges_.swap(other->edges_);
  std::swap(next_vertex_id_, other->next_vertex_id_);
  std::swap(next_edge_id_, other->next_edge_id_);
  stack_.swap(other->stack_);
}

// Inserts the item in the order of ids: mostly at the end.
template <typename T>
int Graph::Insert(std::shared_ptr<T> item, int id, const char* function, std::vector<std::shared_ptr<T>>* items,
                  int* next_id) {
  const auto fail = [&](const std::string& fault) {
    throw GraphError(function + (": " + item->TypeInfo()) + " cannot have the id " + std::to_string(id) + ": " + fault);
  };
  if (id < 0 || id == std::numeric_limits<int>::max()) fail("ids are 0 to 2147483646");
  const auto it = LowerBound(*items, id);
  if (it != items->end() && (*it)->Id() == id) fail((*it)->TypeInfo() + " has it");
  item->id_ = id;
  items->insert(it, std::move(item));
  *next_id = std::max(*next_id, id + 1);
  return id;
}

int Graph::AddVertex(std::shared_ptr<Vertex> vertex, int id) {
  if (!vertex) throw GraphError("AddVertex: the vertex is null");
  if (vertex->Id() >= 0) throw GraphError("AddVertex: " + vertex->Name() + " is already in a graph");
  if (vertex->Dimension() > 0 && !vertex->Parameters().data()) {
    throw GraphError("AddVertex: " + vertex->Name() + " has no memory for its parameters (null)");
  }
  if (!vertex->Parameters().allFinite()) {
    throw GraphError("AddVertex: " + vertex->Name() + " holds a number that is not finite");
  }
  return Insert(std::move(vertex), id, "AddVertex", &vertices_, &next_vertex_id_);
}

int Graph::AddEdge(std::shared_ptr<Edge> edge, int id) {
  if (!edge) throw GraphError("AddEdge: the edge is null");
  if (edge->Id() >= 0) throw GraphError("AddEdge: " + edge->Name() + " is already in a graph");
  const auto& vertices = edge->Vertices();
  if (edge->ResidualDimension() > 0 && !(edge->Residual().data() && edge->Information().data())) {
    throw GraphError("AddEdge: " + edge->Name() + " has no memory for its residual and information (SetMemory)");
  }
  if (vertices.empty()) throw GraphError("AddEdge: " + edge->Name() + " has no vertices");
  for (size_t i = 0; i < vertices.size(); ++i) {
    const auto fail = [&](const std::string& fault) {
      throw GraphError("AddEdge: " + edge->Name() + ", vertex " + std::to_string(i) + ": " + fault);
    };
    if (!vertices[i]) fail("missing (null)");
    if (!Contains(*vertices[i])) fail(vertices[i]->Name() + " is not in this graph");
    for (size_t k = 0; k < i; ++k) {
      if (vertices[k] == vertices[i]) fail(vertices[i]->Name() + " is repeated");
    }
  }
  return Insert(std::move(edge), id, "AddEdge", &edges_, &next_edge_id_);
}

void Graph::RemoveEdge(const std::shared_ptr<Edge>& edge) {
  if (!edge || !Contains(*edge)) throw GraphError("RemoveEdge: the edge is not in this graph");
  const auto it = Find<Edge>(edges_, *edge);
  (*it)->id_ = -1;
  edges_.erase(it);
}

void Graph::RemoveVertices(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  for (const auto& vertex : vertices) {
    if (!vertex || !Contains(*vertex)) throw GraphError("RemoveVertex: the vertex is not in this graph");
  }
  if (vertices.empty()) return;
  for (const auto& vertex : vertices) vertex->id_ = vertex->ordering_id_ = -1;
  const auto is_removed = [](const auto& vertex) { return vertex->id_ < 0; };
  const auto lost_one = [&](const std::shared_ptr<Edge>& edge) {
    const bool lost = std::any_of(edge->Vertices().begin(), edge->Vertices().end(), is_removed);
    if (lost) edge->id_ = -1;
    return lost;
  };
  edges_.erase(std::remove_if(edges_.begin(), edges_.end(), lost_one), edges_.end());
  vertices_.erase(std::remove_if(vertices_.begin(), vertices_.end(), is_removed), vertices_.end());
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

void Graph::Push() {
  stack_.emplace_back();
  for (const auto& vertex : vertices_) stack_.back().push_back({vertex, vertex->Parameters()});
}

void Graph::Pop() {
  if (stack_.empty()) throw GraphError("Pop: no state is on the stack");
  for (const State& state : stack_.back()) {
    if (Contains(*state.vertex)) state.vertex->Parameters() = state.parameters;
  }
  stack_.pop_back();
}

void Graph::DiscardTop() {
  if (stack_.empty()) throw GraphError("DiscardTop: no state is on the stack");
  stack_.pop_back();
}

GraphPointer::GraphPointer(Graph* graph) : graph_(graph) {
  if (!graph) throw GraphError("the solver's graph is null");
  alive_ = graph->alive_;
}

Graph* GraphPointer::Get() const {
  if (alive_.expired()) throw GraphError("the solver's graph has been destroyed; a graph must outlive its solvers");
  return graph_;
}

double Cost(const std::vector<std::shared_ptr<Edge>>& edges) {
  double sum = 0.0;
  for (const auto& edge : edges) {
    edge->ComputeResidual();
    sum += edge->Cost();
  }
  return sum;
}

std::vector<std::shared_ptr<Edge>> EdgesAt(const Graph& graph, const std::vector<std::shared_ptr<Vertex>>& vertices) {
  std::vector<std::shared_ptr<Edge>> edges;
  if (graph.Vertices().empty()) return edges;
  std::vector<char> wanted(static_cast<size_t>(graph.Vertices().back()->Id()) + 1, false);  // by id
  for (const auto& vertex : vertices) {
    if (vertex && graph.Contains(*vertex)) wanted[static_cast<size_t>(vertex->Id())] = true;
  }
  const auto is_wanted = [&](const auto& vertex) { return wanted[static_cast<size_t>(vertex->Id())]; };
  for (const auto& edge : graph.Edges()) {
    if (std::any_of(edge->Vertices().begin(), edge->Vertices().end(), is_wanted)) edges.push_back(edge);
  }
  return edges;
}

std::vector<std::shared_ptr<Edge>> EdgesOutOfDomain(const Graph& graph) {
  std::vector<std::shared_ptr<Edge>> edges;
  const auto is_out = [](const auto& edge) { return !edge->InDomain(); };
  std::copy_if(graph.Edges().begin(), graph.Edges().end(), std::back_inserter(edges), is_out);
  return edges;
}

}  // namespace ch5
