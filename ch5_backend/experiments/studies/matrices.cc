#include "ch5_backend/experiments/studies/matrices.h"

#include <map>
#include <set>

#include <Eigen/Eigenvalues>

#include "ch5_backend/dense/problem.h"

namespace ch5 {

VecX Eigenvalues(const MatXX& H) {
  return Eigen::SelfAdjointEigenSolver<MatXX>(H, Eigen::EigenvaluesOnly).eigenvalues();
}

int NullDimension(const MatXX& H, double relative) {
  const VecX scale = H.diagonal().unaryExpr([](double d) { return d > 0.0 ? 1.0 / std::sqrt(d) : 1.0; });
  const VecX eigenvalues = Eigenvalues(scale.asDiagonal() * H * scale.asDiagonal());
  return static_cast<int>((eigenvalues.array() <= relative * eigenvalues.maxCoeff()).count());
}

FirstRows FirstRowsOf(const Graph& graph) {
  const Ordering ordering = MakeOrdering(graph);
  FirstRows rows;
  for (const auto* vertices : {&ordering.poses, &ordering.landmarks}) {
    for (const auto& vertex : *vertices) rows[vertex.get()] = vertex->OrderingId();
  }
  return rows;
}

MatXX DenseHessian(const Graph& graph) {
  Problem problem(const_cast<Graph*>(&graph));  // only Solve would move the states
  problem.MakeHessian();
  return problem.Hessian();
}

namespace {

bool IsLandmark(const Vertex& vertex) { return vertex.GetRole() == Role::kLandmark; }

void AppendVertices(const Graph& graph, const std::string& scene, CsvTable* table) {
  const FirstRows first_rows = FirstRowsOf(graph);
  std::map<std::string, int> count;
  for (const auto& vertex : graph.Vertices()) {
    const int number = count[vertex->TypeInfo()]++;
    const auto row = first_rows.find(vertex.get());
    if (row == first_rows.end()) continue;
    table->Row(scene, vertex->Id(), vertex->TypeInfo(), number, row->second, vertex->LocalDimension());
  }
}

// Not by address, so that a table's rows have the same order in each run.
struct IdLess {
  bool operator()(const Vertex* a, const Vertex* b) const { return a->Id() < b->Id(); }
};

// Calls add(i, j) for the ids of all pairs of free vertices, i ≥ j.
template <typename Vertices, typename Function>
void ForEachPair(const Vertices& vertices, const Function& add) {
  for (const auto& i : vertices) {
    for (const auto& j : vertices) {
      if (!i->IsFixed() && !j->IsFixed() && i->Id() >= j->Id()) add(*i, *j);
    }
  }
}

}  // namespace

void AppendHessianBlocks(const Graph& graph, const std::string& scene, HessianBlockTables* tables) {
  AppendVertices(graph, scene, &tables->vertices);
  std::map<int, std::set<const Vertex*, IdLess>> poses_of;  // of each landmark, by its id
  for (const auto& edge : graph.Edges()) {
    for (const auto& vertex : edge->Vertices()) tables->edges.Row(scene, edge->Id(), edge->TypeInfo(), vertex->Id());
    ForEachPair(edge->Vertices(), [&](const Vertex& i, const Vertex& j) {
      tables->blocks.Row(scene, "H", i.Id(), j.Id(), "edge", edge->Id());
      if (!IsLandmark(i) && !IsLandmark(j)) tables->blocks.Row(scene, "S", i.Id(), j.Id(), "edge", edge->Id());
      if (IsLandmark(i) && !IsLandmark(j)) poses_of[i.Id()].insert(&j);
      if (IsLandmark(j) && !IsLandmark(i)) poses_of[j.Id()].insert(&i);
    });
  }
  for (const auto& [landmark, poses] : poses_of) {
    ForEachPair(poses, [&, number = landmark](const Vertex& i, const Vertex& j) {
      tables->blocks.Row(scene, "S", i.Id(), j.Id(), "landmark", number);
    });
  }
}

MatXX SlidesChain() {
  const double w1 = 1.0 / (0.1 * 0.1), w2 = 1.0 / (0.2 * 0.2), w3 = 1.0 / (0.3 * 0.3);
  MatXX H(3, 3);
  H << w1, -w1, 0.0,           //
      -w1, w1 + w2 + w3, -w3,  //
      0.0, -w3, w3;
  return H;
}

}  // namespace ch5
