#pragma once
/// What a graded function works on. The judge and the worker build the same scene from its name, its sizes and the seed,
/// by the same code, so that only the student's numbers cross the wire. Nothing in this folder solves anything: a worker
/// links it beside the student's file.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ch5_backend/graph/graph.h"
#include "ch5_backend/simulate/random.h"
#include "ch5_backend/types/vertices.h"
#include "ch5_homework/judge/seed.h"
#include "ch5_homework/judge/values.h"

namespace ch5::homework {

using VertexList = std::vector<std::shared_ptr<Vertex>>;
using EdgeList = std::vector<std::shared_ptr<Edge>>;

/// A vertex or an edge is found again on the other side by its place in the scene.
class Scene {
 public:
  using Sizes = std::vector<int>;

  Scene(std::string name, Sizes sizes) : name_(std::move(name)), sizes_(std::move(sizes)) {}
  virtual ~Scene() = default;
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  const std::string& Name() const { return name_; }
  const Sizes& GetSizes() const { return sizes_; }

  virtual Graph& GetGraph() = 0;
  virtual VertexList Vertices() { return GetGraph().Vertices(); }
  virtual EdgeList Edges() { return GetGraph().Edges(); }

  /// @throws std::invalid_argument if there is no scene of this name
  static std::unique_ptr<Scene> Make(const std::string& name, const Sizes& sizes);

  /// Of all vertices, one after the other.
  VecX States();
  /// @throws WireError unless there is one for each vertex
  void SetStates(const VecX& states);
  /// All that the other side needs: name, sizes, seed, and the states of its vertices.
  void Describe(Values* given);
  /// The described scene, built again.
  static std::unique_ptr<Scene> Make(const Values& given);
  using Maker = std::unique_ptr<Scene> (*)(const std::string& name, const Sizes& sizes);
  /// Before main.
  static bool Add(const std::string& name, Maker maker);

 private:
  std::string name_;
  Sizes sizes_;
};

template <typename S>
std::unique_ptr<S> MakeScene(const Values& given) {
  auto scene = Scene::Make(given);
  auto& own = dynamic_cast<S&>(*scene);
  static_cast<void>(scene.release());  // it is own's now
  return std::unique_ptr<S>(&own);
}

/// An edge whose residual, Jacobians and information are random numbers: H has no structure to hide a mistake in.
/// The residual is NaN before it is computed, so that using it too early shows.
class RandomEdge : public Edge {
 public:
  RandomEdge(int rows, Random* random, VertexList vertices);
  void ComputeResidual() override { r_ = right_r_; }
  void ComputeJacobians() override {}
  /// From now on the residual is `times` as large, perhaps zero.
  void Enlarge(double times) { right_r_ *= times; }
  std::string TypeInfo() const override { return "RandomEdge"; }

 protected:
  VecX r_, right_r_;
  MatXX W_;
  std::vector<MatXX> J_;
};

/// A graph that a function builds.
class GraphScene : public Scene {
 public:
  explicit GraphScene(const std::string& name, const Sizes& sizes = {});
  Graph& GetGraph() override { return graph; }
  VertexList Vertices() override { return vertices.empty() ? graph.Vertices() : vertices; }

  struct Kind {
    const char* name;
    void (*build)(GraphScene* scene);
    uint64_t seed = 0;  ///< of its random numbers, unless its sizes set it
  };
  /// Before main.
  static bool Add(const std::vector<Kind>& kinds);
  RandomEdge& AddRandomEdge(int rows, VertexList vertices);

  Graph graph;
  Random random;  ///< goes on where the function has left off
  std::vector<std::shared_ptr<VertexPose>> poses;
  std::vector<std::shared_ptr<VertexPointXYZ>> points;
  VertexList vertices;  ///< where they are in no graph, or in another order than in the graph
};

// ---- what scenes are made of -----------------------------------------------------------------------------------------

/// Entries uniform on [−1, 1).
MatXX RandomMatrix(int rows, int columns, Random* random);
/// Symmetric, positive definite, smallest eigenvalue ≥ 1, far from a multiple of the identity.
MatXX RandomPositiveDefinite(int size, Random* random);

/// δ of the scenes' Cauchy losses: with r and W of a RandomEdge, s is below δ² at nearly every edge, so that W_ρ is not just ρ'W.
constexpr double kCauchyScale = 2.0;

/// Adds `count` vertices made by `make` to the graph.
template <typename V, typename Maker>
std::vector<std::shared_ptr<V>> AddVertices(Graph* graph, int count, Maker make) {
  std::vector<std::shared_ptr<V>> vertices;
  for (int i = 0; i < count; ++i) {
    vertices.push_back(make());
    graph->AddVertex(vertices.back());
  }
  return vertices;
}

std::vector<std::shared_ptr<VertexPose>> AddPoses(Graph* graph, int count);
std::vector<std::shared_ptr<VertexInverseDepth>> AddInverseDepths(Graph* graph, int count);
std::vector<std::shared_ptr<VertexPointXYZ>> AddPoints(Graph* graph, int count);

/// All rows of their increments together.
int RowsOf(const VertexList& vertices);

}  // namespace ch5::homework
