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

/// The edge between two moving points. Its vertices: the inverse depth; the poses of both frames, unless they are one frame;
/// the places T_B_Ci and T_B_Cj of the cameras on the body, which may be one camera; td.
template <typename... V>
class MovingPointEdge : public SizedEdge<2, V...>, public FastEdge {
 public:
  /// Which vertices these are.
  static constexpr size_t kClock = sizeof...(V) - 1, kCameraJ = kClock - 1;
  static constexpr bool kTwoFrames = kClock > 3;
  static constexpr size_t kCameraI = kTwoFrames ? 3 : 1;

  /// Other measurements; the vertices stay.
  void SetPoints(const MovingPoint& host, const MovingPoint& target) {
    host_ = host;
    target_ = target;
  }
  void ComputeResidual() override;
  void ComputeJacobians() override { Linearize(); }
  void Linearize() override;
  std::unique_ptr<EdgeBatch> MakeBatch() const override;
  bool InDomain() const override;

 protected:
  MovingPointEdge(const MovingPoint& host, const MovingPoint& target, std::shared_ptr<V>... vertices)
      : SizedEdge<2, V...>(std::move(vertices)...), host_(host), target_(target) {}

 private:
  friend struct ReprojectionReader;  // of its batch
  double InverseDepth() const { return this->template GetVertex<0>().InverseDepth(); }
  double TimeOffset() const { return this->template GetVertex<kClock>().GetEstimate()[0]; }
  PointTransfer ToTarget() const;

  MovingPoint host_, target_;
};

extern template class MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexScalar>;

class EdgeReprojectionCalibration
    : public MovingPointEdge<VertexInverseDepth, VertexPose, VertexPose, VertexPose, VertexScalar> {
 public:
  EdgeReprojectionCalibration(std::shared_ptr<VertexInverseDepth> inverse_depth, std::shared_ptr<VertexPose> T_W_Bi,
                              std::shared_ptr<VertexPose> T_W_Bj, std::shared_ptr<VertexPose> T_B_C,
                              std::shared_ptr<VertexScalar> time_offset, const MovingPoint& host,
                              const MovingPoint& target)
      : MovingPointEdge(host, target, std::move(inverse_depth), std::move(T_W_Bi), std::move(T_W_Bj), std::move(T_B_C),
                        std::move(time_offset)) {}
  std::string TypeInfo() const override { return "EdgeReprojectionCalibration"; }
};

}  // namespace ch5
