#pragma once
/// A prior on a pose:  r = [Log(R₀ᵀR); p − p₀]  — rotation first, translation second, while the pose's increment is
/// [δp, δθ]. So the Jacobian is block-antidiagonal (course slides; Forster 2017, eq. A.32):
///
///         δp    δθ
///   r_R [  0   J_r⁻¹(r_R) ]
///   r_p [  I    0         ]

#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

class EdgeSE3Prior : public SizedEdge<6, VertexPose> {
 public:
  /// @param q0, p0  the pose that the prior asks for;  W weighs [rotation; translation], [rad⁻²; m⁻²]
  /// @throws std::invalid_argument if q0 is zero or not finite
  EdgeSE3Prior(std::shared_ptr<VertexPose> pose, const Qd& q0, const Vec3& p0);

  /// W of a pose's uncertainty, whatever r's order.
  /// @param covariance  of the increment [δp; δθ], [m; rad], as Covariance gives it
  /// @throws std::invalid_argument unless it is symmetric positive definite
  void SetCovariance(const Mat66& covariance);

  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return "EdgeSE3Prior"; }

 private:
  Qd q0_;
  Vec3 p0_;
};

}  // namespace ch5
