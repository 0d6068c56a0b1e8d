#include "ch5_backend/types/visual/edge_reprojection_calibration.h"

#include "ch5_backend/types/visual/edge_stereo.h"

namespace ch5 {

// In one frame W may be the body.
template <typename... V>
PointTransfer MovingPointEdge<V...>::ToTarget() const {
  RigidMatrix T_W_Bi, T_W_Bj;
  if constexpr (kTwoFrames) {
    T_W_Bi = RigidMatrix(this->template GetVertex<1>());
    T_W_Bj = RigidMatrix(this->template GetVertex<2>());
  }
  return {host_.At(TimeOffset()).homogeneous(),
          InverseDepth(),
          T_W_Bi,
          T_W_Bj,
          RigidMatrix(this->template GetVertex<kCameraI>()),
          RigidMatrix(this->template GetVertex<kCameraJ>())};
}

template <typename... V>
void MovingPointEdge<V...>::ComputeResidual() {
  this->r_ = Project(ToTarget().p_Cj) - target_.At(TimeOffset());
}

template <typename... V>
bool MovingPointEdge<V...>::InDomain() const {
  return InverseDepth() > 0.0 && ToTarget().p_Cj.z() > 0.0;
}

template <typename... V>
void MovingPointEdge<V...>::Linearize() {
  const RigidMatrix T_B_Ci(this->template GetVertex<kCameraI>()), T_B_Cj(this->template GetVertex<kCameraJ>());
  const PointTransfer transfer = ToTarget();
  this->r_ = Project(transfer.p_Cj) - target_.At(TimeOffset());
  const TransferJacobians d(transfer, InverseDepth(), T_B_Cj);
  this->template J<0>() = d.inverse_depth;
  if constexpr (kTwoFrames) {
    this->template J<1>() = d.pose_i;
    this->template J<2>() = d.pose_j;
  }
  this->template J<kCameraI>().setZero();  // perhaps the same as the next
  this->template J<kCameraJ>() = d.CameraOfTarget(transfer);
  this->template J<kCameraI>() += d.CameraOfHost(transfer, T_B_Ci);
  // dx̂/dtd = −ẋ:  through the host's ray, and directly in the target.
  const Mat23 dr_dp_Ci = d.ByPointInHost(T_B_Ci);
  this->template J<kClock>() = target_.velocity - dr_dp_Ci.leftCols<2>() * host_.velocity / InverseDepth();
}

template class MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexScalar>;
template class MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexPose, VertexScalar>;
template class MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexScalar>;

}  // namespace ch5
