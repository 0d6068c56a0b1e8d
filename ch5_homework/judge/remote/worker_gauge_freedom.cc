/// Stage 4.

#include "ch5_homework/judge/remote/worker.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {
namespace {

void GaugeNullSpace(Reader* in, Writer* out) {
  std::vector<VertexNumbers> vertices;
  GaugeGroup group;
  Unpack(in, &vertices, &group);
  *out << Chosen().gauge_freedom.null_space(MakeVertices(vertices), group);
}

void GaugeProjection(Reader* in, Writer* out) {
  MatXX U, V;
  Unpack(in, &U, &V);
  *out << Chosen().gauge_freedom.projection(U, V);
}

void GaugeMotionJacobian(Reader* in, Writer* out) {
  std::vector<VertexNumbers> vertices;
  double yaw;
  Unpack(in, &vertices, &yaw);
  *out << Chosen().gauge_freedom.motion_jacobian(MakeVertices(vertices), yaw);
}

void TransformCovariance(Reader* in, Writer* out) {
  MatXX covariance, Q, motion;
  Unpack(in, &covariance, &Q, &motion);
  *out << Chosen().gauge_freedom.transform_covariance(covariance, Q, motion);
}

[[maybe_unused]] const bool added =
    Handle("GaugeNullSpace", &GaugeNullSpace) && Handle("GaugeProjection", &GaugeProjection) &&
    Handle("GaugeMotionJacobian", &GaugeMotionJacobian) && Handle("TransformCovariance", &TransformCovariance);

}  // namespace
}  // namespace ch5::homework
