#include "ch5_backend/graph/graph.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "ch5_backend/math/array_memory.h"

namespace ch5 {
Graph::~Graph() { Clear(); }

void Graph::Clear() {
  num_removed_edges_ += Edges().size();
  for (const auto& edge : Edges()) edge->id_ = -1;
  for (const auto& vertex : Vertices()) vertex->id_ = vertex->ordering_id_ = -1;
  edges_.Clear();
  vertices_.Clear();
  is_listed_ = false;
  num_walks_ = 0;
  edge_ids_.clear();
  stack_.clear();
  next_vertex_id_ = next_edge_id_ = 0;
}

void Graph::Swap(Graph* other) noexcept {
  vertices_.Swap(&other->vertices_);
  edges_.Swap(&other->edges_);
  is_listed_ = other->is_listed_.exchange(is_listed_);
  edge_ids_.swap(other->edge_ids_);
  std::swap(num_walks_, other->num_walks_);
  std::swap(next_vertex_id_, other->next_vertex_id_);
  std::swap(next_edge_id_, other->next_edge_id_);
  std::swap(num_removed_edges_, other->num_removed_edges_);
  stack_.swap(other->stack_);
}

// Inserts the item in the order of ids: mostly at the end.
template <typename T>
int Graph::Insert(std::shared_ptr<T> item, int id, const char* function, ById<T>* items, int* next_id) {
  const auto fail = [&](const std::string& fault) {
    throw GraphError(function + (": " + item->TypeInfo()) + " cannot have the id " + std::to_string(id) + ": " + fault);
  };
  if (id < 0 || id == std::numeric_limits<int>::max()) fail("ids are 0 to 2147483646");
  if (const auto holder = items->Find(id)) fail(holder->TypeInfo() + " has it");
  item->id_ = id;
  items->Insert(std::move(item), id);
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
  const Edge& added = *edge;
  Insert(std::move(edge), id, "AddEdge", &edges_, &next_edge_id_);
  if (is_listed_) List(added);
  return id;
}

// ---- The edges of each vertex ----------------------------------------------------------------------------------

void Graph::ListAll() const {
  if (is_listed_) return;
  const std::lock_guard lock(listing_);
  if (is_listed_) return;  // somebody else has
  for (const auto& edge : Edges()) List(*edge);
  is_listed_ = true;
}

const std::vector<int>& Graph::EdgeIdsOf(const Vertex& vertex) const {
  static const std::vector<int> none;
  ListAll();
  const auto found = edge_ids_.find(&vertex);
  return found == edge_ids_.end() ? none : found->second;
}

void Graph::List(const Edge& edge) const {
  for (const auto& vertex : edge.Vertices()) {
    std::vector<int>& ids = edge_ids_[vertex.get()];
    ids.insert(ids.empty() || ids.back() < edge.Id() ? ids.end() : std::lower_bound(ids.begin(), ids.end(), edge.Id()),
               edge.Id());
  }
}

// From the lists of all its vertices but one.
void Graph::Unlist(const Edge& edge, const Vertex* but) {
  for (const auto& vertex : edge.Vertices()) {
    if (vertex.get() == but) continue;
    std::vector<int>& ids = edge_ids_[vertex.get()];
    ids.erase(std::lower_bound(ids.begin(), ids.end(), edge.Id()));
  }
}

std::vector<std::shared_ptr<Edge>> Graph::EdgesOf(const Vertex& vertex) const {
  std::vector<std::shared_ptr<Edge>> edges;
  if (!Contains(vertex)) return edges;
  for (const int id : EdgeIdsOf(vertex)) edges.push_back(edges_.Find(id));
  return edges;
}

void Graph::RemoveEdge(const std::shared_ptr<Edge>& edge) {
  if (!edge || !Contains(*edge)) throw GraphError("RemoveEdge: the edge is not in this graph");
  TakeOut(edge.get(), nullptr);
}

// @param but  a vertex whose list goes as a whole
void Graph::TakeOut(Edge* edge, const Vertex* but) {
  if (is_listed_) Unlist(*edge, but);
  ++num_removed_edges_;
  edges_.Remove(std::exchange(edge->id_, -1));
}

void Graph::RemoveVertices(const std::vector<std::shared_ptr<Vertex>>& vertices) {
  for (const auto& vertex : vertices) {
    if (!vertex || !Contains(*vertex)) throw GraphError("RemoveVertex: the vertex is not in this graph");
  }
  if (vertices.empty()) return;
  // To list the edges of all vertices takes as long as several walks along the edges: a window, which is built anew for each
  // image, is walked along.
  constexpr int kWalks = 4;
  if (!is_listed_ && num_walks_++ < kWalks) {
    for (const auto& edge : EdgesAt(*this, vertices)) TakeOut(edge.get(), nullptr);
  } else {
    ListAll();
  }
  for (const auto& vertex : std::vector(vertices)) {  // a copy: these may be the graph's own
    if (vertex->id_ < 0) continue;                    // named twice
    if (is_listed_) {
      for (const int id : EdgeIdsOf(*vertex)) TakeOut(edges_.Find(id).get(), vertex.get());
      edge_ids_.erase(vertex.get());
    }
    vertices_.Remove(std::exchange(vertex->id_, -1));
    vertex->ordering_id_ = -1;
  }
}

Graph::Solving::Solving(Graph* graph) : solver_(graph->solver_) {
  if (!solver_.compare_exchange_strong(before_, std::this_thread::get_id()) && before_ != std::this_thread::get_id()) {
    throw std::logic_error("two threads solve one graph at once; each needs a graph of its own, or a lock");
  }
}
Graph::Solving::~Solving() { solver_ = before_; }

bool Graph::Contains(const Vertex& vertex) const { return vertices_.Contains(vertex); }
bool Graph::Contains(const Edge& edge) const { return edges_.Contains(edge); }

void Graph::Push() {
  stack_.emplace_back();
  for (const auto& vertex : Vertices()) stack_.back().push_back({vertex, vertex->Parameters()});
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
  const size_t size = edges.size();
  for (size_t e = 0; e < size; ++e) {
    edges[e]->ComputeResidual();
    if (edges.size() != size)
      throw GraphError(edges[e]->Name() + " has changed the graph's edges while it was evaluated");
    sum += edges[e]->Cost();
  }
  return sum;
}

std::vector<std::shared_ptr<Edge>> EdgesAt(const Graph& graph, const std::vector<std::shared_ptr<Vertex>>& vertices) {
  std::vector<std::shared_ptr<Edge>> edges;
  Array<char> wanted(graph.Vertices().size(), false);
  for (const auto& vertex : vertices) {
    if (vertex && graph.Contains(*vertex)) wanted[graph.PositionOf(*vertex)] = true;
  }
  const auto is_wanted = [&](const auto& vertex) { return wanted[graph.PositionOf(*vertex)]; };
  Array<const std::shared_ptr<Edge>*> found;  // then one call takes the memory of all
  for (const auto& edge : graph.Edges()) {
    if (std::any_of(edge->Vertices().begin(), edge->Vertices().end(), is_wanted)) found.push_back(&edge);
  }
  edges.reserve(found.size());
  for (const auto* edge : found) edges.push_back(*edge);
  return edges;
}

std::vector<std::shared_ptr<Edge>> EdgesOutOfDomain(const Graph& graph) {
  std::vector<std::shared_ptr<Edge>> edges;
  const auto is_out = [](const auto& edge) { return !edge->InDomain(); };
  std::copy_if(graph.Edges().begin(), graph.Edges().end(), std::back_inserter(edges), is_out);
  return edges;
}

}  // namespace ch5
