#pragma once
/// Stage 8, the homework's open tasks: four pieces that the other stages use ready-made, each as one function. The library's
/// own are solve/step_strategy, types/visual/edge_reprojection and types/inertial/preintegration.

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

/// What Levenberg–Marquardt does after a trial step.
struct DampingUpdate {
  bool accepted = false;          ///< false: go back to the states before the step
  double lambda = 0.0, nu = 0.0;  ///< for the next trial
};

/// 8a. Nielsen's rule.
/// @param cost, trial_cost    F(x) and F(x ⊞ Δx); the latter may be infinite or NaN
/// @param predicted_decrease  m(0) − m(Δx), of the quadratic model; negative if H is wrong
/// @param lambda, nu          of this trial; ν = 2 at first
/// Source: Nielsen 1999, "Damping parameter in Marquardt's method", eq. 2.4, with g2o's limit ⅔ of the factor
DampingUpdate UpdateDamping(double cost, double trial_cost, double predicted_decrease, double lambda, double nu);

struct ProjectionJacobians {
  Mat26 pose = Mat26::Zero();   ///< ∂r/∂[δp, δθ] of T_W_B
  Mat23 point = Mat23::Zero();  ///< ∂r/∂p_W
};

/// 8b. The Jacobians of r = [p_C.x, p_C.y]/p_C.z − u, where p_W is seen from the body at T_W_B by the camera at T_B_C.
/// p_C.z must not be zero.
ProjectionJacobians LinearizeProjection(const Transform& T_W_B, const Transform& T_B_C, const Vec3& p_W);

/// What an IMU has measured since a first moment, in the body's frame of that moment: without gravity and initial velocity.
struct ImuIncrement {
  Vec3 p = Vec3::Zero();  ///< [m]
  Qd q = Qd::Identity();
  Vec3 v = Vec3::Zero();                                                         ///< [m/s]
  Eigen::Matrix<double, 9, 9> covariance = Eigen::Matrix<double, 9, 9>::Zero();  ///< of [δp, δθ, δv], q ← q ⊗ Exp(δθ)
};

/// 8c. One more step, in which acceleration [m/s²] and rate [rad/s], both without bias, are constant.
/// @param sigma_a, sigma_g  densities of their white noise, [m/s²/√Hz] and [rad/s/√Hz];  @param dt  [s], positive
/// Source: Forster et al., TRO 2017, eqs. 33 and A.7–A.9
ImuIncrement IntegrateImu(const ImuIncrement& before, const Vec3& acceleration, const Vec3& gyroscope, double dt,
                          double sigma_a, double sigma_g);

/// A range's residual and its derivative by the pose.
struct RangeTerm {
  double residual = 0.0;                                ///< prediction − measurement [m]
  JacobianBlock<1, 6> J = JacobianBlock<1, 6>::Zero();  ///< over [δp, δθ]
};

/// 8d. The distance from a beacon to an antenna of the body.
/// @param antenna  in the body's frame;  @param beacon  in the world, not where the antenna is;  @param range  measured [m]
RangeTerm LinearizeRange(const Transform& T_W_B, const Vec3& antenna, const Vec3& beacon, double range);

/// The edge that 8d makes.
class EdgeRange : public SizedEdge<1, VertexPose> {
 public:
  EdgeRange(std::shared_ptr<VertexPose> T_W_B, const Vec3& antenna, const Vec3& beacon, double range)
      : SizedEdge(std::move(T_W_B)), antenna_(antenna), beacon_(beacon), range_(range) {}
  void ComputeResidual() override { r_[0] = Term().residual; }
  void ComputeJacobians() override { J<0>() = Term().J; }
  std::string TypeInfo() const override { return "EdgeRange"; }

 private:
  RangeTerm Term() const {
    const VertexPose& pose = GetVertex<0>();
    return LinearizeRange({pose.q(), pose.p()}, antenna_, beacon_, range_);
  }
  Vec3 antenna_, beacon_;
  double range_;
};

}  // namespace ch5
