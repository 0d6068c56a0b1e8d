#include "ch5_backend/evaluate/trajectory_error.h"

#include <algorithm>

#include "ch5_backend/evaluate/align.h"

namespace ch5 {
namespace {

double Square(double x) { return x * x; }

}  // namespace

// With the means removed, Σ toᵀ R_z(ψ) from = C cos ψ + S sin ψ + const is largest at ψ = atan2(S, C), where
//   C = Σ from_x to_x + from_y to_y,   S = Σ from_x to_y − from_y to_x
std::optional<YawTransform> AlignYaw(const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
  if (from.size() != to.size() || from.size() < 2) return std::nullopt;
  const Vec3 from_mean = Mean(from), to_mean = Mean(to);
  double C = 0.0, S = 0.0, from_spread = 0.0, to_spread = 0.0;
  for (size_t i = 0; i < from.size(); ++i) {
    const Vec2 a = (from[i] - from_mean).head<2>(), b = (to[i] - to_mean).head<2>();
    C += a.dot(b);
    S += a.x() * b.y() - a.y() * b.x();
    from_spread += a.squaredNorm();
    to_spread += b.squaredNorm();
  }
  // The yaw is undetermined if the horizontal spread is mere rounding, or the two sets are unrelated.
  const double rounding = 1e-12 * (1.0 + from_mean.norm() + to_mean.norm());
  if (!(std::min(from_spread, to_spread) > Square(rounding))) return std::nullopt;
  if (!(std::hypot(C, S) > 1e-12 * std::sqrt(from_spread * to_spread))) return std::nullopt;
  YawTransform best;
  best.yaw = std::atan2(S, C);
  best.p = to_mean - best.Rotation() * from_mean;
  return best;
}

YawTransform AlignFirstPose(const Transform& from, const Transform& to) {
  YawTransform alignment;
  alignment.yaw = LogSO3(to.q * from.q.conjugate()).z();
  alignment.p = to.p - alignment.Rotation() * from.p;
  return alignment;
}

std::optional<TrajectoryError> CompareTrajectories(const std::vector<StampedState>& estimate,
                                                   const std::vector<StampedState>& truth,
                                                   const std::optional<YawTransform>& alignment) {
  std::vector<StampedState> estimates, truths;
  std::vector<Vec3> from, to;
  for (const StampedState& state : estimate) {
    const std::optional<StampedState> at_same_time = StateAt(truth, state.t);
    if (!at_same_time) continue;
    estimates.push_back(state);
    truths.push_back(*at_same_time);
    from.push_back(state.T_W_B.p);
    to.push_back(at_same_time->T_W_B.p);
  }
  const std::optional<YawTransform> found = alignment ? alignment : AlignYaw(from, to);
  if (!found || from.empty()) return std::nullopt;

  TrajectoryError error;
  error.alignment = *found;
  if (const std::optional<Similarity> similarity = AlignUmeyama(from, to)) error.scale = similarity->scale;
  for (size_t i = 0; i < from.size(); ++i) {
    const Transform aligned = *found * estimates[i].T_W_B;
    const Transform& T_W_B = truths[i].T_W_B;
    const double distance = (aligned.p - T_W_B.p).norm();
    error.time.push_back(estimates[i].t);
    error.position.push_back(distance);
    error.position_max = std::max(error.position_max, distance);
    error.position_rmse += Square(distance);
    error.rotation_rmse += LogSO3(T_W_B.q.conjugate() * aligned.q).squaredNorm();
    error.yaw_rmse += Square(LogSO3(aligned.q * T_W_B.q.conjugate()).z());
    error.velocity_rmse += (found->Rotation() * estimates[i].v_W - truths[i].v_W).squaredNorm();
  }
  for (double* sum : {&error.position_rmse, &error.rotation_rmse, &error.yaw_rmse, &error.velocity_rmse}) {
    *sum = std::sqrt(*sum / static_cast<double>(from.size()));
  }
  return error;
}

}  // namespace ch5
