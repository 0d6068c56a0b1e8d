#include "ch5_backend/experiments/studies/motion_nees.h"

#include <Eigen/LU>
#include <chrono>
#include <cmath>

#include "ch5_backend/consistency/gauge_audit.h"
#include "ch5_backend/consistency/position_yaw_prior.h"
#include "ch5_backend/marginalize/drop_ordering.h"
#include "ch5_backend/marginalize/marginalize.h"

namespace ch5 {
namespace {

struct RelativeMotion {
  Transform T_0n;
  Mat66 covariance;
};

RelativeMotion MotionAcross(const Window& window) {
  const Frame &oldest = window.frames.front(), &newest = window.frames.back();
  std::vector<std::shared_ptr<Edge>> edges = window.graph.Edges();
  if (!window.prior_fixes_gauge && !window.gauge_prior) edges.push_back(MakePositionYawPrior(oldest.pose, 1e8));
  std::vector<std::shared_ptr<Vertex>> others;  // than the two poses
  for (const auto& vertex : window.graph.Vertices()) {
    if (vertex != oldest.pose && vertex != newest.pose) others.push_back(vertex);
  }
  const MarginalSystem system = EliminateVertices(edges, FixedOrAtEdges(std::move(others), edges));
  const VecX p_inverse = ScalingOf(system.H).cwiseInverse();
  const MatXX scaled = p_inverse.asDiagonal() * system.H * p_inverse.asDiagonal();
  const MatXX covariance = p_inverse.asDiagonal() * scaled.inverse() * p_inverse.asDiagonal();

  const Qd inverse = oldest.pose->q().conjugate();
  RelativeMotion motion{{inverse * newest.pose->q(), inverse * (newest.pose->p() - oldest.pose->p())}, {}};
  const Mat33 R0_t = inverse.toRotationMatrix();
  Eigen::Matrix<double, 6, 12> J = Eigen::Matrix<double, 6, 12>::Zero();
  J.block<3, 3>(0, 0) = -R0_t;
  J.block<3, 3>(0, 3) = Hat(motion.T_0n.p);
  J.block<3, 3>(0, 6) = R0_t;
  J.block<3, 3>(3, 3) = -motion.T_0n.q.toRotationMatrix().transpose();
  J.block<3, 3>(3, 9).setIdentity();
  motion.covariance = J * covariance * J.transpose();
  return motion;
}

// Of position and rotation, from six squares each.
template <typename Squares>
Vec2 RootMean(const std::vector<ComparedMotion>& motions, const Squares& squares) {
  Vec6 sum = Vec6::Zero();
  for (const ComparedMotion& motion : motions) sum += squares(motion);
  return (Vec2(sum.head<3>().sum(), sum.tail<3>().sum()) / static_cast<double>(motions.size())).cwiseSqrt();
}

}  // namespace

double MotionNees::Mean() const {
  double sum = 0.0;
  for (const ComparedMotion& motion : motions) sum += motion.pose.nees;
  return sum / static_cast<double>(motions.size());
}

Vec2 MotionNees::Errors() const {
  return RootMean(motions, [](const ComparedMotion& motion) -> Vec6 { return motion.pose.error.cwiseAbs2(); });
}

Vec2 MotionNees::Claimed() const {
  return RootMean(motions, [](const ComparedMotion& motion) { return motion.variances; });
}

void MotionNees::Compare(const std::vector<StampedState>& recorded, const Window& window) {
  const auto first = StateAt(recorded, window.frames.front().t);
  const auto last = StateAt(recorded, window.frames.back().t);
  if (!first || !last) return;
  const RelativeMotion motion = MotionAcross(window);
  const Qd inverse = first->T_W_B.q.conjugate();
  const Transform true_motion{inverse * last->T_W_B.q, inverse * (last->T_W_B.p - first->T_W_B.p)};
  const PoseConsistency pose = ComparePose(motion.T_0n, motion.covariance + truth, true_motion);
  motions.push_back({window.frames.back().t, pose, motion.covariance.diagonal()});
  if (!window.prior) return;
  GaugeOptions gauge;
  gauge.local_poses = window.LocalPoses();
  for (const GaugeLeak& leak : AuditPrior(window.prior->GetPrior(), gauge)) {
    if (leak.direction == "yaw") yaw_leak += std::abs(leak.information);
  }
  ++priors;
}

std::unique_ptr<WindowPolicy> ComparedBeforeSlides(std::unique_ptr<WindowPolicy> policy,
                                                   const std::vector<StampedState>& recorded, int every,
                                                   MotionNees* found) {
  const auto watch = [&recorded, every, found, count = 0, has_slid = false](
                         Window* window, const std::function<void()>& slide) mutable {
    const size_t before = window->frames.size();
    const auto begin = std::chrono::steady_clock::now();
    if (has_slid && ++count % every == 0) found->Compare(recorded, *window);
    found->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    slide();
    has_slid |= window->frames.size() < before;
  };
  return std::make_unique<WrappedPolicy>(std::move(policy), watch);
}

}  // namespace ch5
