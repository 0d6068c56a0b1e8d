#pragma once
/// A graph on the wire: each edge's residual, Jacobians, information and loss as numbers, before and after it is
/// linearised. On the other side the edge shows the old ones until its Compute functions are called, as the real one
/// does: who forgets to linearise is seen.

#include <memory>
#include <string>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_homework/judge/remote/wire.h"

namespace ch5::homework {

using VertexList = std::vector<std::shared_ptr<Vertex>>;
using EdgeList = std::vector<std::shared_ptr<Edge>>;

struct VertexNumbers {
  std::string type;
  int id = -1;
  Role role = Role::kPose;
  bool fixed = false;
  int local_dimension = 0;
  VecX x;
};

struct Linearisation {
  VecX r;
  std::vector<MatXX> J;
};

struct EdgeNumbers {
  std::string type;
  int id = -1, level = 0;
  std::vector<int> vertices;  ///< places in GraphNumbers::vertices
  MatXX W;
  double cauchy = 0.0;  ///< δ of a Cauchy loss, 0 without a loss
  Linearisation before, after;
};

struct GraphNumbers {
  std::vector<VertexNumbers> vertices;
  std::vector<EdgeNumbers> edges;
};

Writer& operator<<(Writer& out, const VertexNumbers& vertex);
Reader& operator>>(Reader& in, VertexNumbers& vertex);
Writer& operator<<(Writer& out, const GraphNumbers& graph);
Reader& operator>>(Reader& in, GraphNumbers& graph);

VertexNumbers NumbersOf(const Vertex& vertex);
std::vector<VertexNumbers> NumbersOf(const VertexList& vertices);
/// The edges are linearised on the way, so `before` is what they held until then.
/// @throws std::logic_error if an edge has a vertex that is not in the list, or another loss than Cauchy's
GraphNumbers NumbersOf(const VertexList& vertices, const EdgeList& edges);

/// A vertex of the named type, one of types/vertices.h.
/// @throws WireError if there is none of this name, or the numbers do not fit it
std::shared_ptr<Vertex> MakeVertex(const VertexNumbers& numbers);
VertexList MakeVertices(const std::vector<VertexNumbers>& numbers);
/// Parameters and whether it is fixed.  @throws WireError if the number of parameters is another
void SetVertex(const VertexNumbers& numbers, Vertex* vertex);

/// The place of a vertex in a list: kNull of a null pointer, kUnknown if it is not there.
constexpr int kNull = -1, kUnknown = -2;
int PlaceOf(const Vertex* vertex, const VertexList& vertices);

/// An edge that shows the numbers it was given.
class WireEdge : public Edge {
 public:
  enum : int { kResidual = 1, kJacobians = 2 };

  /// @throws WireError if the numbers do not fit together
  WireEdge(const EdgeNumbers& numbers, const VertexList& all);
  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return type_; }

  /// Other numbers of the same sizes, shown as before a linearisation.
  void Set(const EdgeNumbers& numbers);
  /// Which of its Compute functions have been called since then.
  int Linearised() const { return linearised_; }

 private:
  void ShowJacobians(const Linearisation& numbers);

  std::string type_;
  VecX r_;
  MatXX W_, J_;  // the vertices' blocks side by side
  Linearisation after_;
  int linearised_ = 0;
};

/// A graph that came over the wire, with the ids that it had. Vertices and edges without an id stay outside of it.
class WireGraph {
 public:
  explicit WireGraph(const GraphNumbers& numbers);
  /// The same graph with new numbers.  @throws WireError if it is another graph
  void Refresh(const GraphNumbers& numbers);

  const VertexList& AllVertices() const { return vertices_; }
  const std::vector<std::shared_ptr<WireEdge>>& AllEdges() const { return edges_; }
  Graph* Get() { return &graph_; }
  /// WireEdge::Linearised of all edges.
  std::vector<int> Linearised() const;

 private:
  Graph graph_;
  VertexList vertices_;
  std::vector<std::shared_ptr<WireEdge>> edges_;
};

/// Puts into real edges what the other side has left in theirs.
void ShowAsLinearised(const GraphNumbers& numbers, const std::vector<int>& linearised, const EdgeList& edges);

}  // namespace ch5::homework
