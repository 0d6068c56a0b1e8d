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
  EdgeSE3Prior(std::shared_ptr<VertexPose> pose, const Qd& q0, const Vec3& p0);

  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return "EdgeSE3Prior"; }

 private:
  Qd q0_;
  Vec3 p0_;
};

}  // namespace ch5
