#pragma once
/// The graph: which unknowns there are and which residuals tie them together. No ordering, no matrices.

#include <memory>
#include <stdexcept>
#include <vector>

#include "ch5_backend/graph/edge.h"
#include "ch5_backend/graph/vertex.h"

namespace ch5 {

/// A graph that cannot be built as asked; the message names the vertex or edge.
class GraphError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// A vertex or edge belongs to one graph at a time, and is free again when it is removed or the graph is gone.
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

  /// @return the vertex' id
  /// @throws GraphError if it is null, already in a graph, or holds a number that is not finite
  int AddVertex(std::shared_ptr<Vertex> vertex);

  /// @return the edge's id
  /// @throws GraphError if it is null, already in a graph, or one of its vertices is missing, repeated, or not in
  ///         this graph
  int AddEdge(std::shared_ptr<Edge> edge);

  /// Removes an edge, or a vertex with all its edges. The other ids stay.
  /// @throws GraphError if it is not in this graph
  void RemoveEdge(const std::shared_ptr<Edge>& edge);
  void RemoveVertex(const std::shared_ptr<Vertex>& vertex);

  /// In order of insertion; ids ascend.
  const std::vector<std::shared_ptr<Vertex>>& Vertices() const { return vertices_; }
  const std::vector<std::shared_ptr<Edge>>& Edges() const { return edges_; }

  /// The edges at a vertex, in order of insertion. Walks all edges.
  std::vector<std::shared_ptr<Edge>> EdgesOf(const Vertex& vertex) const;

  bool Contains(const Vertex& vertex) const;
  bool Contains(const Edge& edge) const;

 private:
  void Swap(Graph* other) noexcept;

  std::vector<std::shared_ptr<Vertex>> vertices_;
  std::vector<std::shared_ptr<Edge>> edges_;
  int next_vertex_id_ = 0;
  int next_edge_id_ = 0;
};

/// ½ Σ ρ(rᵀWr) over all edges at the present state; residuals are left computed.
double ComputeCost(const Graph& graph);

}  // namespace ch5
