/// Stage 3 in the worker. The edges that it adds come back as numbers, and the judge adds equal ones.

#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_homework/judge/remote/mono_ba_wire.h"
#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

// Poses and depths in the places where the edge has them, or null.
template <typename V>
std::shared_ptr<V> VertexAt(const EdgeNumbers& numbers, size_t i, const VertexList& vertices) {
  const auto place = static_cast<size_t>(numbers.vertices.at(i));
  return place < vertices.size() ? std::dynamic_pointer_cast<V>(vertices[place]) : nullptr;
}

// The prior whose residual at its pose is the one that came:  r = [Log(q₀⁻¹q); p − p₀].
std::shared_ptr<Edge> MakePrior(const EdgeNumbers& numbers, const VertexList& vertices) {
  const auto pose = numbers.vertices.size() == 1 ? VertexAt<VertexPose>(numbers, 0, vertices) : nullptr;
  const VecX& r = numbers.after.r;
  if (!pose || r.size() != 6) return nullptr;
  return std::make_shared<EdgeSE3Prior>(pose, pose->q() * ExpSO3(-r.head<3>()), pose->p() - r.tail<3>());
}

// The measurement of the scene, moved by what its residual differs from the one that came.
std::shared_ptr<Edge> MakeReprojection(const EdgeNumbers& numbers, const MonoBaScene& scene, const MonoBa& problem) {
  const VertexList vertices = VerticesOf(problem);
  if (numbers.vertices.size() != 3 || numbers.after.r.size() != 2) return nullptr;
  const auto depth = VertexAt<VertexInverseDepth>(numbers, 0, vertices);
  const auto host = VertexAt<VertexPose>(numbers, 1, vertices), target = VertexAt<VertexPose>(numbers, 2, vertices);
  if (!depth || !host || !target) return nullptr;
  const size_t k = static_cast<size_t>(numbers.vertices[0]) - problem.poses.size();
  const Vec2& u_host = scene.pixels[static_cast<size_t>(numbers.vertices[1])][k];
  const Vec2& u_target = scene.pixels[static_cast<size_t>(numbers.vertices[2])][k];
  EdgeReprojection measured(depth, host, target, u_host, u_target);
  measured.ComputeResidual();
  return std::make_shared<EdgeReprojection>(depth, host, target, u_host,
                                            u_target + measured.GetResidual() - numbers.after.r);
}

std::shared_ptr<Edge> MakeEdge(const EdgeNumbers& numbers, const MonoBaScene& scene, const MonoBa& problem) {
  const VertexList vertices = VerticesOf(problem);
  std::shared_ptr<Edge> edge;
  if (numbers.type == "EdgeSE3Prior") edge = MakePrior(numbers, vertices);
  if (numbers.type == "EdgeReprojection") edge = MakeReprojection(numbers, scene, problem);
  if (!edge) return std::make_shared<WireEdge>(numbers, vertices);  // of another type: at least it is seen
  edge->SetInformation(numbers.W);
  edge->SetLevel(numbers.level);
  if (numbers.cauchy > 0.0) edge->SetLossFunction(std::make_shared<CauchyLoss>(numbers.cauchy));
  return edge;
}

void RemoteAddMonoBaEdges(const MonoBaScene& scene, double pixel_information, double prior_weight, MonoBa* problem) {
  const VertexList vertices = VerticesOf(*problem);
  GraphNumbers numbers;
  Ask("AddMonoBaEdges", Pack(scene, NumbersOf(vertices), pixel_information, prior_weight), &numbers);
  try {
    if (numbers.vertices.size() < vertices.size()) throw WireError("vertices are missing");
    for (size_t i = 0; i < vertices.size(); ++i) {
      if (!numbers.vertices[i].x.allFinite()) throw WireError("a vertex holds a number that is not finite");
      SetVertex(numbers.vertices[i], vertices[i].get());
    }
    for (const EdgeNumbers& one : numbers.edges) problem->graph.AddEdge(MakeEdge(one, scene, *problem));
  } catch (const WireError& error) {
    throw WorkerFailure(std::string("GARBAGE in the reply to AddMonoBaEdges: ") + error.what());
  }
}

[[maybe_unused]] const bool added = [] {
  Linked()->add_mono_ba_edges = &RemoteAddMonoBaEdges;
  return true;
}();

}  // namespace
}  // namespace ch5::homework
