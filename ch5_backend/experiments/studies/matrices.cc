#include "ch5_backend/experiments/studies/matrices.h"

#include <map>
#include <set>

#include <Eigen/Eigenvalues>

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
  FirstRows rows;
  int size = 0;
  for (const auto& vertex : graph.Vertices()) {
    if (vertex->IsFixed()) continue;
    rows[vertex.get()] = size;
    size += vertex->LocalDimension();
  }
  return rows;
}

MatXX DenseHessian(const Graph& graph, int* pose_rows) {
  const FirstRows row = FirstRowsOf(graph);
  int size = 0;
  *pose_rows = 0;
  for (const auto& vertex : graph.Vertices()) {
    if (vertex->IsFixed()) continue;
    size += vertex->LocalDimension();
    if (vertex->GetRole() == Role::kPose) *pose_rows = size;
  }
  MatXX H = MatXX::Zero(size, size);
  for (const auto& edge : graph.Edges()) {
    edge->Linearize();
    double drho;
    MatXX W;
    edge->RobustInfo(&drho, &W);
    const auto& vertices = edge->Vertices();
    for (size_t i = 0; i < vertices.size(); ++i) {
      for (size_t j = 0; j < vertices.size(); ++j) {
        if (vertices[i]->IsFixed() || vertices[j]->IsFixed()) continue;
        H.block(row.at(vertices[i].get()), row.at(vertices[j].get()), vertices[i]->LocalDimension(),
                vertices[j]->LocalDimension()) += edge->Jacobian(i).transpose() * W * edge->Jacobian(j);
      }
    }
  }
  return H;
}

namespace {

bool IsLandmark(const Vertex& vertex) { return vertex.GetRole() == Role::kLandmark; }

void AppendVertices(const Graph& graph, const std::string& scene, CsvTable* table) {
  const FirstRows first_rows = FirstRowsOf(graph);
  std::map<std::string, int> count;
  for (const auto& vertex : graph.Vertices()) {
    const int number = count[vertex->TypeInfo()]++;
    if (vertex->IsFixed()) continue;
    table->Row(scene, vertex->Id(), vertex->TypeInfo(), number, first_rows.at(vertex.get()), vertex->LocalDimension());
  }
}

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
  std::map<int, std::set<const Vertex*>> poses_of;  // of each landmark, by its id
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
