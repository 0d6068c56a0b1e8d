#pragma once
/// gauge_prior.cc: stage 3. The edges that it adds come back as numbers, and the judge adds equal ones.

#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/scenes/bundle.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace gauge_prior {

struct EdgeNumbers {
  std::string type;
  std::vector<int> vertices;  ///< places in the scene
  MatXX W;
  bool has_loss = false;  ///< no check asks which one
  int level = 0;
  VecX r;
};

}  // namespace gauge_prior

inline auto Fields(gauge_prior::EdgeNumbers& e, Wire) {
  return std::tie(e.type, e.vertices, e.W, e.has_loss, e.level, e.r);
}

namespace gauge_prior {

struct AddMonoBaEdges {
  static constexpr char kName[] = "AddMonoBaEdges";
  static std::vector<EdgeNumbers> Run(StartScene& scene, double pixel_information, double prior_weight,
                                      States* states) {
    const VertexList vertices = scene.Vertices();
    Chosen().add_mono_ba_edges(scene.scene, pixel_information, prior_weight, &scene.ba);
    *states = States(vertices);
    std::vector<EdgeNumbers> numbers;
    for (const auto& edge : scene.ba.graph.Edges()) {
      edge->ComputeResidual();
      const LossFunction* loss = edge->GetLossFunction();
      numbers.push_back({edge->TypeInfo(), PlacesOf(VertexList(edge->Vertices()), vertices), edge->Information(),
                         loss != nullptr && dynamic_cast<const TrivialLoss*>(loss) == nullptr, edge->Level(),
                         edge->Residual()});
    }
    return numbers;
  }
};

// The scene's pose or depth at the edge's i-th vertex, or null.
template <typename V>
std::shared_ptr<V> VertexAt(const EdgeNumbers& e, size_t i, const VertexList& vertices) {
  const auto place = static_cast<size_t>(e.vertices.at(i));
  return place < vertices.size() ? std::dynamic_pointer_cast<V>(vertices[place]) : nullptr;
}

// The prior whose residual at its pose is the one that came:  r = [Log(q₀⁻¹q); p − p₀].
inline std::shared_ptr<Edge> MakePrior(const EdgeNumbers& e, const VertexList& vertices) {
  const auto pose = e.vertices.size() == 1 ? VertexAt<VertexPose>(e, 0, vertices) : nullptr;
  if (!pose || e.r.size() != 6) return nullptr;
  return std::make_shared<EdgeSE3Prior>(pose, pose->q() * ExpSO3(-e.r.head<3>()), pose->p() - e.r.tail<3>());
}

// The measurement of the scene, moved by what its residual differs from the one that came.
inline std::shared_ptr<Edge> MakeReprojection(const EdgeNumbers& e, const StartScene& scene,
                                              const VertexList& vertices) {
  if (e.vertices.size() != 3 || e.r.size() != 2) return nullptr;
  const auto depth = VertexAt<VertexInverseDepth>(e, 0, vertices);
  const auto host = VertexAt<VertexPose>(e, 1, vertices), target = VertexAt<VertexPose>(e, 2, vertices);
  if (!depth || !host || !target) return nullptr;
  const size_t k = static_cast<size_t>(e.vertices[0]) - scene.ba.poses.size();
  const Vec2& u_host = scene.scene.pixels[static_cast<size_t>(e.vertices[1])][k];
  const Vec2& u_target = scene.scene.pixels[static_cast<size_t>(e.vertices[2])][k];
  EdgeReprojection measured(depth, host, target, u_host, u_target);
  measured.ComputeResidual();
  return std::make_shared<EdgeReprojection>(depth, host, target, u_host, u_target + measured.GetResidual() - e.r);
}

inline std::shared_ptr<Edge> MakeEdge(const EdgeNumbers& e, StartScene& scene) {
  std::shared_ptr<Edge> edge;
  if (e.type == "EdgeSE3Prior") edge = MakePrior(e, scene.Vertices());
  if (e.type == "EdgeReprojection") edge = MakeReprojection(e, scene, scene.Vertices());
  if (!edge) return std::make_shared<ForeignEdge>(e.type.substr(0, 80));
  edge->SetInformation(e.W);
  edge->SetLevel(e.level);
  if (e.has_loss) edge->SetLossFunction(std::make_shared<CauchyLoss>(1.0));
  return edge;
}

inline void RemoteAddMonoBaEdges(const MonoBaScene&, double pixel_information, double prior_weight, MonoBa* problem) {
  auto& scene = dynamic_cast<StartScene&>(Scene::Of(&problem->graph));
  States states;
  const auto edges = Ask<AddMonoBaEdges>(scene, pixel_information, prior_weight, &states);
  states.RequireFinite();
  states.SetInto(scene.Vertices());
  for (const EdgeNumbers& one : edges) problem->graph.AddEdge(MakeEdge(one, scene));
}

inline void Remote(Submission* s) { s->add_mono_ba_edges = &RemoteAddMonoBaEdges; }
inline void Serve() { HandleAll<AddMonoBaEdges>(); }

}  // namespace gauge_prior
}  // namespace ch5::homework
