#pragma once
/// A prior on a pose:  r = [Log(R₀ᵀR); p − p₀]  — rotation first, translation second, while the pose's increment is
/// [δp, δθ]. So the Jacobian's blocks stand across (course slides; Forster 2017, eq. A.32):
///
///         δp    δθ
///   r_R [  0   J_r⁻¹(r_R) ]
///   r_p [  I    0         ]

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

class EdgeSE3Prior : public SizedEdge<6, VertexPose> {
 public:
  /// @param q0, p0  the pose that the prior asks for;  W weighs [rad²; m²] in the order [rotation, translation]
  EdgeSE3Prior(std::shared_ptr<VertexPose> pose, const Qd& q0, const Vec3& p0)
      : SizedEdge(std::move(pose)), q0_(q0.normalized()), p0_(p0) {}

  void ComputeResidual() override { r_ << LogSO3(q0_.conjugate() * GetVertex<0>().q()), GetVertex<0>().p() - p0_; }
  void ComputeJacobians() override {
    const Vec3 r_R = LogSO3(q0_.conjugate() * GetVertex<0>().q());
    J<0>().setZero();
    J<0>().block<3, 3>(0, 3) = RightJacobianInverseSO3(r_R);
    J<0>().block<3, 3>(3, 0).setIdentity();
  }
  std::string TypeInfo() const override { return "EdgeSE3Prior"; }

 private:
  Qd q0_;
  Vec3 p0_;
};

}  // namespace ch5
