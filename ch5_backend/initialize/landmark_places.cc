#include "ch5_backend/initialize/landmark_places.h"

#include <map>

#include "ch5_backend/math/psd.h"
#include "ch5_backend/types/pose_graph/edge_sensor.h"

namespace ch5 {
namespace {

struct Normal {
  MatXX H;
  VecX b;
};

// Adds the edge's part to the problem of its landmark, vertex 1.
void Add(Edge* edge, Normal* normal) {
  if (const auto* bearing = dynamic_cast<const EdgeBearing*>(edge)) {
    const auto& pose = bearing->GetVertex<0>();
    const double angle = pose.Theta() + bearing->z();
    const Vec2 n(-std::sin(angle), std::cos(angle));
    normal->H += n * n.transpose();
    normal->b -= n * n.dot(bearing->GetVertex<1>().GetEstimate() - pose.p());
    return;
  }
  edge->Linearize();
  const MatXX J_W = edge->Jacobian(1).transpose() * edge->Information();
  normal->H += J_W * edge->Jacobian(1);
  normal->b -= J_W * edge->Residual();
}

}  // namespace

void PlaceLandmark(const std::vector<std::shared_ptr<Edge>>& edges, Vertex* landmark) {
  const int dim = landmark->LocalDimension();
  Normal normal{MatXX::Zero(dim, dim), VecX::Zero(dim)};
  for (const auto& edge : edges) Add(edge.get(), &normal);
  landmark->Plus(VecX(PseudoInversePsd(normal.H) * normal.b).data());
}

void PlaceLandmarks(Graph* graph) {
  std::map<int, std::vector<std::shared_ptr<Edge>>> edges;  // by the landmark's id
  for (const auto& edge : graph->Edges()) {
    if (edge->Vertices().size() < 2 || edge->Vertices()[0]->GetRole() != Role::kPose) continue;
    const Vertex& landmark = *edge->Vertices()[1];
    if (landmark.GetRole() == Role::kLandmark && !landmark.IsFixed()) edges[landmark.Id()].push_back(edge);
  }
  for (const auto& vertex : graph->Vertices()) {
    if (const auto found = edges.find(vertex->Id()); found != edges.end()) PlaceLandmark(found->second, vertex.get());
  }
}

}  // namespace ch5
