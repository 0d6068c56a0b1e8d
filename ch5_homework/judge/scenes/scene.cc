#include "ch5_homework/judge/scenes/scene.h"

#include <algorithm>
#include <map>
#include <stdexcept>

namespace ch5::homework {
namespace {

std::map<std::string, Scene::Maker>& Makers() {
  static std::map<std::string, Scene::Maker> makers;
  return makers;
}

std::map<std::string, GraphScene::Build>& Builds() {
  static std::map<std::string, GraphScene::Build> builds;
  return builds;
}

std::vector<Scene*>& Alive() {
  static std::vector<Scene*> alive;
  return alive;
}

template <typename Has>
Scene& Find(const char* what, const Has& has) {
  for (Scene* scene : Alive()) {
    if (has(scene)) return *scene;
  }
  throw std::logic_error(std::string("no scene has this ") + what);
}

template <typename T>
bool Holds(const std::vector<std::shared_ptr<T>>& items, const T* wanted) {
  return std::any_of(items.begin(), items.end(), [&](const auto& item) { return item.get() == wanted; });
}

int NextNumber() {
  static int number = 0;
  return ++number;
}

}  // namespace

// ---- scenes ----------------------------------------------------------------------------------------------------------

Scene::Scene(std::string name, Sizes sizes) : name_(std::move(name)), sizes_(std::move(sizes)), number_(NextNumber()) {
  Alive().push_back(this);
}

Scene::~Scene() { Alive().erase(std::find(Alive().begin(), Alive().end(), this)); }

void Scene::Step() {
  ++steps_;
  NextStep();
}

std::unique_ptr<Scene> Scene::Make(const std::string& name, const Sizes& sizes) {
  const auto maker = Makers().find(name);
  if (maker == Makers().end()) throw std::invalid_argument("there is no scene " + name);
  return maker->second(name, sizes);
}

void Scene::Describe(Values* given) {
  const VertexList vertices = Vertices();
  Eigen::Index size = 0;
  for (const auto& vertex : vertices) size += vertex->Dimension();
  VecX states(size), fixed(vertices.size());
  Eigen::Index row = 0, k = 0;
  for (const auto& vertex : vertices) {
    states.segment(row, vertex->Dimension()) = vertex->Parameters();
    row += vertex->Dimension();
    fixed[k++] = vertex->IsFixed();
  }
  given->Put("scene", name_);
  given->Put("sizes",
             Eigen::Map<const Eigen::VectorXi>(sizes_.data(), static_cast<Eigen::Index>(sizes_.size())).cast<double>());
  if (DrawnSeed()) given->Put("seed", std::to_string(*DrawnSeed()));
  given->Put("states", states);
  given->Put("fixed", fixed);
}

std::unique_ptr<Scene> Scene::Make(const Values& given) {
  if (given.Has("seed")) TakeSeed("--seed=" + given.Word("seed"));
  const VecX sizes = given.Vector("sizes"), states = given.Vector("states"), fixed = given.Vector("fixed");
  std::unique_ptr<Scene> scene = Make(given.Word("scene"), Sizes(sizes.data(), sizes.data() + sizes.size()));
  Eigen::Index row = 0, k = 0;
  for (const auto& vertex : scene->Vertices()) {
    if (row + vertex->Dimension() > states.size() || k >= fixed.size())
      throw WireError("not one state for each vertex");
    vertex->Parameters() = states.segment(row, vertex->Dimension());
    row += vertex->Dimension();
    vertex->SetFixed(fixed[k++] != 0.0);
  }
  return scene;
}

bool Scene::Add(const std::string& name, Maker maker) { return Makers().emplace(name, maker).second; }

Scene& Scene::Of(const Graph* graph) {
  return Find("graph", [&](Scene* scene) { return &scene->GetGraph() == graph; });
}
Scene& Scene::Of(const Vertex* vertex) {
  return Find("vertex", [&](Scene* scene) { return Holds(scene->Vertices(), vertex); });
}
Scene& Scene::Of(const Edge* edge) {
  return Find("edge", [&](Scene* scene) { return Holds(scene->Edges(), edge); });
}

GraphScene::GraphScene(const std::string& name, const Sizes& sizes) : Scene(name, sizes) { Builds().at(name)(this); }

bool GraphScene::Add(const std::vector<std::pair<std::string, Build>>& scenes) {
  for (const auto& [name, build] : scenes) {
    Builds()[name] = build;
    Scene::Add(name, [](const std::string& one, const Sizes& sizes) -> std::unique_ptr<Scene> {
      return std::make_unique<GraphScene>(one, sizes);
    });
  }
  return true;
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

std::vector<std::shared_ptr<VertexPose>> AddPoses(Graph* graph, int count) {
  return AddVertices<VertexPose>(graph, count, [] { return std::make_shared<VertexPose>(); });
}

std::vector<std::shared_ptr<VertexInverseDepth>> AddInverseDepths(Graph* graph, int count) {
  return AddVertices<VertexInverseDepth>(graph, count, [] { return std::make_shared<VertexInverseDepth>(0.2); });
}

std::vector<std::shared_ptr<VertexPointXYZ>> AddPoints(Graph* graph, int count) {
  return AddVertices<VertexPointXYZ>(graph, count, [] { return std::make_shared<VertexPointXYZ>(Vec3(1, 2, 5)); });
}

}  // namespace ch5::homework
