#pragma once
// Small scenes that between them hold every kind of structure a solver meets.
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "ch5_backend/graph/graph.h"

namespace ch5::test {

struct Scene {
  std::string name;
  bool has_gauge_freedom;  // or nearly so: H is singular, and steps need damping
  std::function<void(Graph*)> build;
};
inline void PrintTo(const Scene& scene, std::ostream* out) { *out << scene.name; }

const std::vector<Scene>& AllScenes();
const Scene& SceneNamed(const std::string& name);

}  // namespace ch5::test
