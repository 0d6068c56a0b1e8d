#pragma once
/// The reprojection of an inverse-depth landmark while the camera is being calibrated: its extrinsic T_B_C, and its
/// time offset td, by which its clock is late against the IMU's.
///
/// A frame's pose belongs to the time stamp + td_k, td_k being the offset known when the frame came. If td is another,
/// the image was taken later by td − td_k, and its points were, at the pose's time, still on their way:
///
///   x̂ = x − (td − td_k) ẋ        for the host's point and the target's alike
///   r = π(T_C_B T_Bj_W T_W_Bi T_B_C [x̂_i, 1]/λ) − x̂_j
///
/// Either of the two unknowns may be fixed.  Source: Qin, Shen, "Online Temporal Calibration for Monocular
/// Visual-Inertial Systems", IROS 2018, eqs. 7–9.

#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5 {

/// A point on the normalized plane and how it moves there.
struct MovingPoint {
  Vec2 x = Vec2::Zero();
  Vec2 velocity = Vec2::Zero();  ///< [1/s]
  double clock_offset = 0.0;     ///< td_k [s]

  Vec2 At(double time_offset) const { return x - (time_offset - clock_offset) * velocity; }
};

class EdgeReprojectionCalibration
    : public SizedEdge<2, VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexScalar>,
      public FastEdge {
 public:
  EdgeReprojectionCalibration(std::shared_ptr<VertexInverseDepth> inverse_depth, std::shared_ptr<VertexPose> T_W_Bi,
                              std::shared_ptr<VertexPose> T_W_Bj, std::shared_ptr<VertexPose> T_B_C,
                              std::shared_ptr<VertexScalar> time_offset, const MovingPoint& host,
                              const MovingPoint& target);
  /// Other measurements; the vertices stay.
  void SetPoints(const MovingPoint& host, const MovingPoint& target) {
    host_ = host;
    target_ = target;
  }
  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::unique_ptr<EdgeBatch> MakeBatch() const override;
  bool InDomain() const override;
  std::string TypeInfo() const override { return "EdgeReprojectionCalibration"; }

 private:
  friend struct ReprojectionReader;
  Vec3 PointInTarget() const;  // p_Cj

  MovingPoint host_, target_;
};

}  // namespace ch5
