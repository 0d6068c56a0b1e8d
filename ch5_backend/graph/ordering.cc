#include "ch5_backend/graph/ordering.h"

namespace ch5 {

Ordering MakeOrdering(const Graph& graph) {
  constexpr int kSeen = 0, kUnseen = -1;
  for (const auto& vertex : graph.Vertices()) vertex->SetOrderingId(kUnseen);
  for (const auto& edge : graph.Edges()) {
    for (const auto& vertex : edge->Vertices()) vertex->SetOrderingId(vertex->IsFixed() ? kUnseen : kSeen);
  }

  Ordering ordering;
  for (const auto& vertex : graph.Vertices()) {
    if (vertex->OrderingId() == kUnseen) continue;
    const bool is_pose = vertex->GetRole() == Role::kPose;
    (is_pose ? ordering.poses : ordering.landmarks).push_back(vertex);
  }
  for (const auto& vertex : ordering.poses) {
    vertex->SetOrderingId(ordering.dim_poses);
    ordering.dim_poses += vertex->LocalDimension();
  }
  for (const auto& vertex : ordering.landmarks) {
    vertex->SetOrderingId(ordering.dim_poses + ordering.dim_landmarks);
    ordering.dim_landmarks += vertex->LocalDimension();
  }
  return ordering;
}

}  // namespace ch5
