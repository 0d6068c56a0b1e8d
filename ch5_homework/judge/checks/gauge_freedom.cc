/// gauge_freedom.cc, stage 4: each function by itself, on the vertices of a scene or on matrices.

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_homework/judge/checks/check.h"
#include "ch5_homework/judge/scenes/scene.h"

namespace ch5::homework {
namespace {

void NullSpace(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<GraphScene>(given);
  VertexList vertices = scene->Vertices();
  if (given.Has("only")) vertices = {vertices.at(static_cast<size_t>(given.Int("only")))};
  answer->Put("U", student.gauge_freedom.null_space(vertices, static_cast<GaugeGroup>(given.Int("group"))));
}

void Project(const Submission& student, const Values& given, Answer* answer) {
  answer->Put("Q", student.gauge_freedom.projection(given["U"], given["V"]));
}

void Move(const Submission& student, const Values& given, Answer* answer) {
  const auto scene = MakeScene<GraphScene>(given);
  answer->Put("motion", student.gauge_freedom.motion_jacobian(scene->Vertices(), given.Number("yaw")));
}

void Transform(const Submission& student, const Values& given, Answer* answer) {
  answer->Put("transformed", student.gauge_freedom.transform_covariance(given["covariance"], given["motion"],
                                                                        given["Q"], given["Q_C"]));
}

[[maybe_unused]] const bool added =
    (Linked()->gauge_freedom = {&GaugeNullSpace, &GaugeProjection, &GaugeMotionJacobian, &TransformCovariance},
     AddChecks({{"GaugeNullSpace", &NullSpace},
                {"GaugeProjection", &Project},
                {"GaugeMotionJacobian", &Move},
                {"TransformCovariance", &Transform}}));

}  // namespace
}  // namespace ch5::homework
