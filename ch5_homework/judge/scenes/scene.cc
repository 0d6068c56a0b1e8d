#include "ch5_homework/judge/scenes/scene.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>

namespace ch5::homework {
namespace {

std::map<std::string, Scene::Maker>& Makers() {
  static std::map<std::string, Scene::Maker> makers;
  return makers;
}

std::map<std::string, GraphScene::Kind>& Kinds() {
  static std::map<std::string, GraphScene::Kind> kinds;
  return kinds;
}

}  // namespace

// ---- scenes ----------------------------------------------------------------------------------------------------------

std::unique_ptr<Scene> Scene::Make(const std::string& name, const Sizes& sizes) {
  const auto maker = Makers().find(name);
  if (maker == Makers().end()) throw std::invalid_argument("there is no scene " + name);
  return maker->second(name, sizes);
}

VecX Scene::States() {
  VecX states;
  for (const auto& vertex : Vertices()) {
    states.conservativeResize(states.size() + vertex->Dimension());
    states.tail(vertex->Dimension()) = vertex->Parameters();
  }
  return states;
}

void Scene::SetStates(const VecX& states) {
  if (states.size() != States().size()) throw WireError("not one state for each vertex");
  Eigen::Index row = 0;
  for (const auto& vertex : Vertices()) {
    vertex->Parameters() = states.segment(row, vertex->Dimension());
    row += vertex->Dimension();
  }
}

void Scene::Describe(Values* given) {
  const VertexList vertices = Vertices();
  VecX fixed(vertices.size()), sizes(sizes_.size());
  std::transform(vertices.begin(), vertices.end(), fixed.data(), [](const auto& vertex) { return vertex->IsFixed(); });
  std::copy(sizes_.begin(), sizes_.end(), sizes.data());
  given->Put("scene", name_);
  given->Put("sizes", sizes);
  if (DrawnSeed()) given->Put("seed", std::to_string(*DrawnSeed()));
  given->Put("states", States());
  given->Put("fixed", fixed);
}

std::unique_ptr<Scene> Scene::Make(const Values& given) {
  if (given.Has("seed")) TakeSeed("--seed=" + given.Word("seed"));
  const VecX sizes = given.Vector("sizes"), fixed = given.Vector("fixed");
  std::unique_ptr<Scene> scene = Make(given.Word("scene"), Sizes(sizes.data(), sizes.data() + sizes.size()));
  scene->SetStates(given.Vector("states"));
  const VertexList vertices = scene->Vertices();
  if (fixed.size() != static_cast<Eigen::Index>(vertices.size())) throw WireError("not one mark for each vertex");
  for (size_t k = 0; k < vertices.size(); ++k) vertices[k]->SetFixed(fixed[static_cast<Eigen::Index>(k)] != 0.0);
  return scene;
}

bool Scene::Add(const std::string& name, Maker maker) { return Makers().emplace(name, maker).second; }

GraphScene::GraphScene(const std::string& name, const Sizes& sizes)
    : Scene(name, sizes), random(Seed(Kinds().at(name).seed)) {
  Kinds().at(name).build(this);
}

bool GraphScene::Add(const std::vector<Kind>& kinds) {
  for (const Kind& kind : kinds) {
    Kinds().emplace(kind.name, kind);
    Scene::Add(kind.name, [](const std::string& one, const Sizes& sizes) -> std::unique_ptr<Scene> {
      return std::make_unique<GraphScene>(one, sizes);
    });
  }
  return true;
}

RandomEdge& GraphScene::AddRandomEdge(int rows, VertexList vertices) {
  auto edge = std::make_shared<RandomEdge>(rows, &random, std::move(vertices));
  graph.AddEdge(edge);
  return *edge;
}

// ---- what they are made of -------------------------------------------------------------------------------------------

MatXX RandomMatrix(int rows, int columns, Random* random) {
  MatXX A(rows, columns);
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) A(i, j) = random->Uniform(-1.0, 1.0);
  }
  return A;
}

MatXX RandomPositiveDefinite(int size, Random* random) {
  const MatXX A = RandomMatrix(size, size, random);
  return A * A.transpose() + MatXX::Identity(size, size);
}

RandomEdge::RandomEdge(int rows, Random* random, VertexList vertices)
    : Edge(rows, std::move(vertices), nullptr, nullptr),
      r_(VecX::Constant(rows, std::numeric_limits<double>::quiet_NaN())),
      right_r_(RandomMatrix(rows, 1, random)),
      W_(MatXX::Identity(rows, rows)) {
  SetMemory(r_.data(), W_.data());
  SetInformation(RandomPositiveDefinite(rows, random));
  for (const auto& vertex : Vertices()) J_.push_back(RandomMatrix(rows, vertex->LocalDimension(), random));
  std::transform(J_.begin(), J_.end(), jacobians_.begin(), [](MatXX& J) { return J.data(); });
}

std::vector<std::shared_ptr<VertexPose>> AddPoses(Graph* graph, int count) {
  return AddVertices<VertexPose>(graph, count, [] { return std::make_shared<VertexPose>(); });
}

std::vector<std::shared_ptr<VertexInverseDepth>> AddInverseDepths(Graph* graph, int count) {
  return AddVertices<VertexInverseDepth>(graph, count, [] { return std::make_shared<VertexInverseDepth>(0.2); });
}

std::vector<std::shared_ptr<VertexPointXYZ>> AddPoints(Graph* graph, int count) {
  return AddVertices<VertexPointXYZ>(graph, count, [] { return std::make_shared<VertexPointXYZ>(Vec3(1, 2, 5)); });
}

int RowsOf(const VertexList& vertices) {
  return std::accumulate(vertices.begin(), vertices.end(), 0,
                         [](int rows, const auto& vertex) { return rows + vertex->LocalDimension(); });
}

}  // namespace ch5::homework
