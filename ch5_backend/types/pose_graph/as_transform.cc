#include "ch5_backend/types/pose_graph/as_transform.h"

#include <stdexcept>

#include "ch5_backend/types/pose_graph/edge_sensor.h"

namespace ch5 {
namespace {

Transform InSpace(const Vec2& p, double theta) {
  return {Qd(std::cos(0.5 * theta), 0.0, 0.0, std::sin(0.5 * theta)), Vec3(p.x(), p.y(), 0.0)};
}

}  // namespace

std::optional<Transform> PoseOf(const Vertex& vertex) {
  if (const auto* pose = dynamic_cast<const VertexPose*>(&vertex)) return Transform{pose->q(), pose->p()};
  if (const auto* pose = dynamic_cast<const VertexSE2*>(&vertex)) return InSpace(pose->p(), pose->Theta());
  return std::nullopt;
}

void MoveTo(const Transform& T_W_i, Vertex* vertex) {
  if (auto* pose = dynamic_cast<VertexPose*>(vertex)) return pose->SetPose(T_W_i.q, T_W_i.p);
  auto* planar = dynamic_cast<VertexSE2*>(vertex);
  if (planar == nullptr) throw std::invalid_argument("MoveTo: " + vertex->TypeInfo() + " is no pose");
  planar->SetEstimate({T_W_i.p.x(), T_W_i.p.y(), WrapAngle(2.0 * std::atan2(T_W_i.q.z(), T_W_i.q.w()))});
}

std::optional<Transform> MeasurementOf(const Edge& edge) {
  if (const auto* between = dynamic_cast<const EdgeSE3Between*>(&edge))
    return Transform{between->q_z(), between->p_z()};
  if (const auto* between = dynamic_cast<const EdgeSE2Between*>(&edge))
    return InSpace(between->p_z(), between->ThetaZ());
  if (const auto* offset = dynamic_cast<const EdgeOffset<VertexPose>*>(&edge)) {
    const Vec7 z = offset->Measurement();
    return Transform{RotationIn(z), z.head<3>()};
  }
  if (const auto* offset = dynamic_cast<const EdgeOffset<VertexSE2>*>(&edge)) {
    const Vec3 z = offset->Measurement();
    return InSpace(z.head<2>(), z[2]);
  }
  return std::nullopt;
}

std::shared_ptr<Edge> MakeBetween(const std::shared_ptr<Vertex>& i, const std::shared_ptr<Vertex>& j,
                                  const Transform& T_i_j, const MatXX& W) {
  std::shared_ptr<Edge> edge;
  if (const auto flat = std::dynamic_pointer_cast<VertexSE2>(i)) {
    edge = std::make_shared<EdgeSE2Between>(flat, std::dynamic_pointer_cast<VertexSE2>(j), T_i_j.p.head<2>(),
                                            2.0 * std::atan2(T_i_j.q.z(), T_i_j.q.w()));
  } else {
    edge = std::make_shared<EdgeSE3Between>(std::dynamic_pointer_cast<VertexPose>(i),
                                            std::dynamic_pointer_cast<VertexPose>(j), T_i_j.q, T_i_j.p);
  }
  edge->SetInformation(W);
  return edge;
}

}  // namespace ch5
