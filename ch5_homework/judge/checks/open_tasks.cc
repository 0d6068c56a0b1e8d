/// open_tasks.cc, stage 8: four functions of numbers alone.

#include "ch5_backend/open_tasks/open_tasks.h"
#include "ch5_homework/judge/checks/check.h"

namespace ch5::homework {
namespace {

void Damp(const Submission& student, const Values& given, Answer* answer) {
  const DampingUpdate next =
      student.open_tasks.update_damping(given.Number("cost"), given.Number("trial_cost"), given.Number("predicted"),
                                        given.Number("lambda"), given.Number("nu"));
  answer->Put({{"accepted", next.accepted}, {"lambda", next.lambda}, {"nu", next.nu}});
}

void Project(const Submission& student, const Values& given, Answer* answer) {
  const ProjectionJacobians J =
      student.open_tasks.linearize_projection(given.Pose("T_W_B"), given.Pose("T_B_C"), given.Sized("p_W", 3, 1));
  answer->Put({{"pose", J.pose}, {"point", J.point}});
}

void Integrate(const Submission& student, const Values& given, Answer* answer) {
  const Transform pose = given.Pose("pose");
  const ImuIncrement before{pose.p, pose.q, given.Sized("v", 3, 1), given.Sized("covariance", 9, 9)};
  const ImuIncrement after =
      student.open_tasks.integrate_imu(before, given.Sized("a", 3, 1), given.Sized("w", 3, 1), given.Number("dt"),
                                       given.Number("sigma_a"), given.Number("sigma_g"));
  answer->Put({{"pose", Transform{after.q, after.p}}, {"v", after.v}, {"covariance", after.covariance}});
}

void Range(const Submission& student, const Values& given, Answer* answer) {
  const RangeTerm term = student.open_tasks.linearize_range(given.Pose("T_W_B"), given.Sized("antenna", 3, 1),
                                                            given.Sized("beacon", 3, 1), given.Number("range"));
  answer->Put({{"residual", term.residual}, {"J", term.J}});
}

[[maybe_unused]] const bool added =
    (Linked()->open_tasks = {&UpdateDamping, &LinearizeProjection, &IntegrateImu, &LinearizeRange},
     AddChecks({{"UpdateDamping", &Damp},
                {"LinearizeProjection", &Project},
                {"IntegrateImu", &Integrate},
                {"LinearizeRange", &Range}}));

}  // namespace
}  // namespace ch5::homework
