#pragma once
/// ∂(x ⊞ δ)/∂δ of the manifolds, for edges that AutoDiffEdge differentiates by their parameters.

#include "ch5_backend/types/vertices.h"

namespace ch5 {

/// 7×6:  p + δp,  q ⊗ [½δθ, 1]:  ∂q_xyz/∂δθ = ½(q_w I + [q_xyz]),  ∂q_w/∂δθ = −½ q_xyzᵀ.  Solà, "Quaternion kinematics".
inline Eigen::Matrix<double, 7, 6> PlusJacobian(const VertexPose& pose) {
  const Qd q = pose.q();
  Eigen::Matrix<double, 7, 6> J = Eigen::Matrix<double, 7, 6>::Zero();
  J.topLeftCorner<3, 3>().setIdentity();
  J.block<3, 3>(3, 3) = 0.5 * (q.w() * Mat33::Identity() + Hat(q.vec()));
  J.bottomRightCorner<1, 3>() = -0.5 * q.vec().transpose();
  return J;
}

}  // namespace ch5
