#pragma once
/// The graph: which unknowns there are and which residuals connect them. No ordering, no matrices.

#include <memory>
#include <stdexcept>
#include <thread>
#include <unordered_map>
#include <vector>

#include "ch5_backend/graph/by_id.h"
#include "ch5_backend/graph/edge.h"
#include "ch5_backend/graph/vertex.h"

namespace ch5 {

/// A graph that cannot be built as asked; the message names the vertex or edge.
class GraphError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// A vertex or edge belongs to one graph at a time, until it is removed or the graph is destroyed.
/// Threads: a graph with its vertices and edges is used by one thread at a time, and what solves it counts as one; two graphs
/// share nothing. Only what is const here may be called by several at once, until the next change. Loss functions may be
/// shared: they are not changed.
class Graph {
 public:
  Graph() = default;
  ~Graph();
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;
  Graph(Graph&& other) noexcept { Swap(&other); }
  Graph& operator=(Graph&& other) noexcept {
    Swap(&other);
    return *this;
  }

  /// @param id  its number; without one, the next after the largest so far. All sums are taken in the order of
  ///            ids, so vertices and edges with given ids may be added in any order and give the same bits
  /// @return the vertex' id
  /// @throws GraphError if it is null, already in a graph, or holds a number that is not finite; or if the id is taken
  ///         or negative
  int AddVertex(std::shared_ptr<Vertex> vertex, int id);
  int AddVertex(std::shared_ptr<Vertex> vertex) { return AddVertex(std::move(vertex), next_vertex_id_); }

  /// @return the edge's id
  /// @throws GraphError if it is null, already in a graph, or one of its vertices is missing, repeated, or not in
  ///         this graph; or if the id is taken or negative
  int AddEdge(std::shared_ptr<Edge> edge, int id);
  int AddEdge(std::shared_ptr<Edge> edge) { return AddEdge(std::move(edge), next_edge_id_); }

  /// Removes an edge, or a vertex with all its edges, in time proportional to the vertex' degree (see EdgesOf). The other ids
  /// stay.
  /// @throws GraphError if it is not in this graph
  void RemoveEdge(const std::shared_ptr<Edge>& edge);
  void RemoveVertex(const std::shared_ptr<Vertex>& vertex) { RemoveVertices({vertex}); }
  /// Several at once: all or, where one is not in this graph, none.
  void RemoveVertices(const std::vector<std::shared_ptr<Vertex>>& vertices);
  /// Removes everything, the pushed states too; ids begin at 0 again.
  void Clear();

  /// A stack of states: Push saves the parameters of all vertices, Pop restores those saved last, to the bit, and
  /// DiscardTop drops them. Vertices that were added or removed since are not touched.
  /// @throws GraphError if nothing is on the stack
  void Push();
  void Pop();
  void DiscardTop();
  size_t StackSize() const { return stack_.size(); }

  /// In order of id. The references are good until the graph changes.
  const std::vector<std::shared_ptr<Vertex>>& Vertices() const { return vertices_.All(); }
  const std::vector<std::shared_ptr<Edge>>& Edges() const { return edges_.All(); }

  /// The edges at a vertex, in order of id. The first call, or the fifth of RemoveVertices, lists those of all vertices; from
  /// then on it takes time proportional to the vertex' degree.
  std::vector<std::shared_ptr<Edge>> EdgesOf(const Vertex& vertex) const;

  /// As long as it lives, one thread solves the graph.
  class Solving {
   public:
    /// @throws std::logic_error if another thread solves it
    explicit Solving(Graph* graph);
    ~Solving();
    Solving(const Solving&) = delete;
    Solving& operator=(const Solving&) = delete;

   private:
    std::atomic<std::thread::id>& solver_;
    std::thread::id before_;  // this thread in a solve within a solve, else none
  };

  /// How many edges have been removed so far, with their vertices or alone: who follows a graph that grows asks.
  size_t NumRemovedEdges() const { return num_removed_edges_; }

  bool Contains(const Vertex& vertex) const;
  bool Contains(const Edge& edge) const;

  /// The place among Vertices() or Edges() of one that is in the graph, good until the graph changes. A table of what is known
  /// of each goes by it: ids may be as large as int.
  size_t PositionOf(const Vertex& vertex) const { return vertices_.PositionOf(vertex); }
  size_t PositionOf(const Edge& edge) const { return edges_.PositionOf(edge); }

 private:
  /// What Push saves of a vertex.
  struct State {
    std::shared_ptr<Vertex> vertex;
    VecX parameters;
  };

  friend class GraphPointer;

  void Swap(Graph* other) noexcept;
  template <typename T>
  static int Insert(std::shared_ptr<T> item, int id, const char* function, ById<T>* items, int* next_id);
  void ListAll() const;
  const std::vector<int>& EdgeIdsOf(const Vertex& vertex) const;
  void List(const Edge& edge) const;
  void Unlist(const Edge& edge, const Vertex* but);
  void TakeOut(Edge* edge, const Vertex* but);

  ById<Vertex> vertices_;
  ById<Edge> edges_;
  mutable std::mutex listing_;
  mutable std::atomic<bool> is_listed_ = false;
  int num_walks_ = 0;                                                     // of RemoveVertices along all edges
  mutable std::unordered_map<const Vertex*, std::vector<int>> edge_ids_;  // ascending; if is_listed_
  int next_vertex_id_ = 0;
  int next_edge_id_ = 0;
  size_t num_removed_edges_ = 0;
  std::atomic<std::thread::id> solver_ = {};
  std::vector<std::vector<State>> stack_;
  std::shared_ptr<const void> alive_ = std::make_shared<char>();  // ends with this object; moves to no other
};

/// A pointer to a graph that somebody else owns. To use it after the graph's end is an error in words, not a crash.
class GraphPointer {
 public:
  /// @throws GraphError if it is null
  explicit GraphPointer(Graph* graph);
  /// @throws GraphError if the graph has been destroyed
  Graph* Get() const;
  /// So that what was written for a Graph* compiles.
  operator Graph*() const { return Get(); }
  Graph& operator*() const { return *Get(); }
  Graph* operator->() const { return Get(); }

 private:
  Graph* graph_;
  std::weak_ptr<const void> alive_;
};

/// The edges of the graph at one or more of these vertices, each once, in order of id. Walks all edges, which for
/// many vertices is quicker than EdgesOf.
std::vector<std::shared_ptr<Edge>> EdgesAt(const Graph& graph, const std::vector<std::shared_ptr<Vertex>>& vertices);

/// The edges that are not in their domain at the present state, in order of id (Edge::InDomain).
std::vector<std::shared_ptr<Edge>> EdgesOutOfDomain(const Graph& graph);

/// ½ Σ ρ(rᵀWr) over the edges, or over all of the graph's, at the present state; the residuals are computed on the way.
double Cost(const std::vector<std::shared_ptr<Edge>>& edges);
inline double Cost(const Graph& graph) { return Cost(graph.Edges()); }

}  // namespace ch5
