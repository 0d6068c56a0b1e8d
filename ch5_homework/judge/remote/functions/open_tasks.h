#pragma once
/// open_tasks.cc: stage 8. What a function returns travels as the columns of one matrix.

#include "ch5_homework/judge/remote/remote.h"
#include "ch5_homework/judge/submission.h"

namespace ch5::homework::open_tasks {

struct Damping {
  static constexpr char kName[] = "UpdateDamping";
  static Vec3 Run(double cost, double trial_cost, double predicted_decrease, double lambda, double nu) {
    const DampingUpdate next = Chosen().open_tasks.update_damping(cost, trial_cost, predicted_decrease, lambda, nu);
    return {next.accepted ? 1.0 : 0.0, next.lambda, next.nu};
  }
};
struct Projection {
  static constexpr char kName[] = "LinearizeProjection";
  static Mat29 Run(const Qd& q_W_B, const Vec3& p_W_B, const Qd& q_B_C, const Vec3& p_B_C, const Vec3& p_W) {
    const ProjectionJacobians J = Chosen().open_tasks.linearize_projection({q_W_B, p_W_B}, {q_B_C, p_B_C}, p_W);
    return (Mat29() << J.pose, J.point).finished();
  }
};
struct Imu {
  static constexpr char kName[] = "IntegrateImu";
  using State = Eigen::Matrix<double, 10, 1>;  // p, q, v
  using Covariance = Eigen::Matrix<double, 9, 9>;
  static State Stacked(const ImuIncrement& of) { return (State() << of.p, of.q.coeffs(), of.v).finished(); }
  static ImuIncrement Taken(const State& state, const Covariance& covariance) {
    return {state.head<3>(), Qd(state.segment<4>(3).data()), state.tail<3>(), covariance};
  }
  static std::pair<State, Covariance> Run(const State& state, const Covariance& covariance, const Vec3& acceleration,
                                          const Vec3& gyroscope, double dt, const Vec2& sigmas) {
    const ImuIncrement after =
        Chosen().open_tasks.integrate_imu(Taken(state, covariance), acceleration, gyroscope, dt, sigmas[0], sigmas[1]);
    return {Stacked(after), after.covariance};
  }
};
struct Range {
  static constexpr char kName[] = "LinearizeRange";
  static Vec7 Run(const Qd& q, const Vec3& p, const Vec3& antenna, const Vec3& beacon, double range) {
    const RangeTerm term = Chosen().open_tasks.linearize_range({q, p}, antenna, beacon, range);
    return (Vec7() << term.residual, term.J.transpose()).finished();
  }
};

inline void Remote(Submission* s) {
  s->open_tasks = {[](double cost, double trial_cost, double predicted_decrease, double lambda, double nu) {
                     const Vec3 next = Ask<Damping>(cost, trial_cost, predicted_decrease, lambda, nu);
                     return DampingUpdate{next[0] != 0.0, next[1], next[2]};
                   },
                   [](const Transform& T_W_B, const Transform& T_B_C, const Vec3& p_W) {
                     const Mat29 J = Ask<Projection>(T_W_B.q, T_W_B.p, T_B_C.q, T_B_C.p, p_W);
                     return ProjectionJacobians{J.leftCols<6>(), J.rightCols<3>()};
                   },
                   [](const ImuIncrement& before, const Vec3& acceleration, const Vec3& gyroscope, double dt,
                      double sigma_a, double sigma_g) {
                     const auto [state, covariance] = Ask<Imu>(Imu::Stacked(before), before.covariance, acceleration,
                                                               gyroscope, dt, Vec2(sigma_a, sigma_g));
                     return Imu::Taken(state, covariance);
                   },
                   [](const Transform& T_W_B, const Vec3& antenna, const Vec3& beacon, double range) {
                     const Vec7 term = Ask<Range>(T_W_B.q, T_W_B.p, antenna, beacon, range);
                     return RangeTerm{term[0], term.tail<6>().transpose()};
                   }};
}
inline void Serve() { HandleAll<Damping, Projection, Imu, Range>(); }

}  // namespace ch5::homework::open_tasks
