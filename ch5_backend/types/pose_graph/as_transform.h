#pragma once
/// Poses and edges of a pose graph, in space or in the plane z = 0, as rigid transforms: for what treats both alike.

#include <optional>

#include "ch5_backend/math/transform.h"
#include "ch5_backend/types/pose_graph/edge_between.h"

namespace ch5 {

/// T_W_i of a VertexPose or VertexSE2; nullopt for another type.
std::optional<Transform> PoseOf(const Vertex& vertex);

/// Moves a VertexPose or VertexSE2 to T_W_i, in the plane to its x, y and yaw.
/// @throws std::invalid_argument for another type
void MoveTo(const Transform& T_W_i, Vertex* vertex);

/// The measured T_i_j of an EdgeSE3Between, EdgeSE2Between or EdgeOffset; nullopt for another type.
std::optional<Transform> MeasurementOf(const Edge& edge);

/// An EdgeSE3Between, or in the plane an EdgeSE2Between, of this measurement.
/// @param i, j  both VertexPose, or both VertexSE2
std::shared_ptr<Edge> MakeBetween(const std::shared_ptr<Vertex>& i, const std::shared_ptr<Vertex>& j,
                                  const Transform& T_i_j, const MatXX& W);

}  // namespace ch5
