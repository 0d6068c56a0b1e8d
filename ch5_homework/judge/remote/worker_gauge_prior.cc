/// Stage 3.

#include "ch5_homework/judge/remote/mono_ba_wire.h"
#include "ch5_homework/judge/remote/worker.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

void AddMonoBaEdges(Reader* in, Writer* out) {
  MonoBaScene scene;
  std::vector<VertexNumbers> vertices;
  double pixel_information, prior_weight;
  Unpack(in, &scene, &vertices, &pixel_information, &prior_weight);
  MonoBa problem;
  for (const auto& vertex : MakeVertices(vertices)) {
    problem.graph.AddVertex(vertex);
    if (auto pose = std::dynamic_pointer_cast<VertexPose>(vertex)) problem.poses.push_back(pose);
    if (auto depth = std::dynamic_pointer_cast<VertexInverseDepth>(vertex)) problem.landmarks.push_back(depth);
  }
  Chosen().add_mono_ba_edges(scene, pixel_information, prior_weight, &problem);
  *out << NumbersOf(problem.graph.Vertices(), problem.graph.Edges());
}

[[maybe_unused]] const bool added = Handle("AddMonoBaEdges", &AddMonoBaEdges);

}  // namespace
}  // namespace ch5::homework
