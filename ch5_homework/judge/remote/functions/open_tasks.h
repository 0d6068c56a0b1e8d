#pragma once
/// open_tasks.cc: stage 8.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework {

inline auto Fields(Transform& T, Wire) { return std::tie(T.q, T.p); }
inline auto Fields(DampingUpdate& next, Wire) { return std::tie(next.accepted, next.lambda, next.nu); }
inline auto Fields(ProjectionJacobians& J, Wire) { return std::tie(J.pose, J.point); }
inline auto Fields(ImuIncrement& of, Wire) { return std::tie(of.p, of.q, of.v, of.covariance); }
inline auto Fields(RangeTerm& term, Wire) { return std::tie(term.residual, term.J); }

namespace open_tasks {

/// On both sides: each takes values and returns one.
template <auto kFunction, const char* kNamed>
struct Task;
template <typename R, typename... A, R (*OpenTasks::*kFunction)(A...), const char* kNamed>
struct Task<kFunction, kNamed> {
  static constexpr const char* kName = kNamed;
  static R Run(A... given) { return (Chosen().open_tasks.*kFunction)(given...); }
  static R Remote(A... given) { return Ask<Task>(given...); }
};

inline constexpr char kDamping[] = "UpdateDamping", kProjection[] = "LinearizeProjection", kImu[] = "IntegrateImu",
                      kRange[] = "LinearizeRange";
using Damping = Task<&OpenTasks::update_damping, kDamping>;
using Projection = Task<&OpenTasks::linearize_projection, kProjection>;
using Imu = Task<&OpenTasks::integrate_imu, kImu>;
using Range = Task<&OpenTasks::linearize_range, kRange>;

inline void Remote(Submission* s) {
  s->open_tasks = {&Damping::Remote, &Projection::Remote, &Imu::Remote, &Range::Remote};
}
inline void Serve() { HandleAll<Damping, Projection, Imu, Range>(); }

}  // namespace open_tasks
}  // namespace ch5::homework
