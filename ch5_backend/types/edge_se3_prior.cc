#include "ch5_backend/types/edge_se3_prior.h"

#include "ch5_backend/math/psd.h"

namespace ch5 {

EdgeSE3Prior::EdgeSE3Prior(std::shared_ptr<VertexPose> pose, const Qd& q0, const Vec3& p0)
    : SizedEdge(std::move(pose)), q0_(RotationOf(q0, "EdgeSE3Prior")), p0_(p0) {}

// r ≈ [δθ; δp]
void EdgeSE3Prior::SetCovariance(const Mat66& covariance) {
  Mat66 A = Mat66::Zero();
  A.topRightCorner<3, 3>().setIdentity();
  A.bottomLeftCorner<3, 3>().setIdentity();
  SetInformation(A * InverseOfCovariance(covariance, TypeInfo()) * A.transpose());
}

void EdgeSE3Prior::ComputeResidual() { r_ << LogSO3(q0_.conjugate() * GetVertex<0>().q()), GetVertex<0>().p() - p0_; }

void EdgeSE3Prior::ComputeJacobians() {
  const Vec3 r_R = LogSO3(q0_.conjugate() * GetVertex<0>().q());
  J<0>().setZero();
  J<0>().block<3, 3>(0, 3) = RightJacobianInverseSO3(r_R);
  J<0>().block<3, 3>(3, 0).setIdentity();
}

}  // namespace ch5
