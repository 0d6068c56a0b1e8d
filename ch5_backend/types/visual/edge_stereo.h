#pragma once
/// What camera 1 sees of a landmark that camera 0 hosts: the reprojections of a stereo pair, or of any two cameras whose
/// images are taken at the same time.
///
///   p_Bi = T_B_C0 [x̂_i, 1]/λ,   p_Bj = T_Bj_W T_W_Bi p_Bi,   r = π(T_B_C1⁻¹ p_Bj) − x̂_j
///
/// In the host's own frame p_Bj = p_Bi: the body's pose drops out, and what remains is the depth by the base line of the
/// two cameras. x̂ is the point at the time of the frame's pose, as in edge_reprojection_calibration.h; both cameras have
/// one clock. Any of the vertices may be fixed.
///
/// Source: Qin, Cao, Pan, Shen, "A General Optimization-based Framework for Local Odometry Estimation with Multiple
/// Sensors", 2019 (VINS-Fusion's factors of two frames and two cameras, and of one frame and two cameras).

#include "ch5_backend/types/visual/edge_reprojection_calibration.h"

namespace ch5 {

extern template class MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexPose, VertexScalar>;
extern template class MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexScalar>;

/// Host in camera 0 of frame i, target in camera 1 of another frame j.
class EdgeStereo
    : public MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexPose, VertexScalar> {
 public:
  EdgeStereo(std::shared_ptr<VertexInverseDepth> inverse_depth, std::shared_ptr<VertexPose> T_W_Bi,
             std::shared_ptr<VertexPose> T_W_Bj, std::shared_ptr<VertexPose> T_B_C0, std::shared_ptr<VertexPose> T_B_C1,
             std::shared_ptr<VertexScalar> time_offset, const MovingPoint& host, const MovingPoint& target)
      : MovingPointEdge(host, target, std::move(inverse_depth), std::move(T_W_Bi), std::move(T_W_Bj), std::move(T_B_C0),
                        std::move(T_B_C1), std::move(time_offset)) {}
  std::string TypeInfo() const override { return "EdgeStereo"; }
};

/// Both in the same frame.
class EdgeStereoHost : public MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexScalar> {
 public:
  EdgeStereoHost(std::shared_ptr<VertexInverseDepth> inverse_depth, std::shared_ptr<VertexPose> T_B_C0,
                 std::shared_ptr<VertexPose> T_B_C1, std::shared_ptr<VertexScalar> time_offset, const MovingPoint& host,
                 const MovingPoint& target)
      : MovingPointEdge(host, target, std::move(inverse_depth), std::move(T_B_C0), std::move(T_B_C1),
                        std::move(time_offset)) {}
  std::string TypeInfo() const override { return "EdgeStereoHost"; }
};

}  // namespace ch5
