#include "ch5_homework/judge/remote/travel.h"

namespace ch5::homework {

States::States(const VertexList& vertices) {
  for (const auto& vertex : vertices) {
    x.push_back(vertex->Parameters());
    fixed.push_back(vertex->IsFixed());
  }
}

void States::SetInto(const VertexList& vertices) const {
  if (x.size() != vertices.size() || fixed.size() != vertices.size()) throw WireError("not one state for each vertex");
  for (size_t k = 0; k < vertices.size(); ++k) {
    if (x[k].size() != vertices[k]->Dimension()) throw WireError("a state of another size");
  }
  for (size_t k = 0; k < vertices.size(); ++k) {
    vertices[k]->Parameters() = x[k];
    vertices[k]->SetFixed(fixed[k] != 0);
  }
}

void States::RequireFinite() const {
  for (const VecX& one : x) {
    if (!one.allFinite()) throw WireError("a vertex holds a number that is not finite");
  }
}

void SendScene(Scene* scene, Writer* out) {
  *out << scene->Number() << scene->Name() << scene->GetSizes() << scene->Steps() << DrawnSeed().has_value()
       << DrawnSeed().value_or(0) << States(scene->Vertices());
}

Scene* FetchScene(Reader* in) {
  static std::map<int, std::unique_ptr<Scene>> scenes;
  int number, steps;
  std::string name;
  Scene::Sizes sizes;
  bool seeded;
  uint64_t seed;
  States states;
  *in >> number >> name >> sizes >> steps >> seeded >> seed >> states;
  if (seeded) DrawnSeed() = seed;
  std::unique_ptr<Scene>& scene = scenes[number];
  if (!scene) scene = Scene::Make(name, sizes);
  while (scene->Steps() < steps) scene->Step();
  states.SetInto(scene->Vertices());
  return scene.get();
}

}  // namespace ch5::homework
