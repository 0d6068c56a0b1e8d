#pragma once
/// Reprojection edges on the normalized image plane z = 1 (dimensionless, focal length 1).
///
///   landmark:  p_Ci = [u_i, v_i, 1]/λ  in its host camera i,  or p_W directly
///   r = π(p_Cj) − [u_j, v_j],   p_Cj as in point_transfer.h
///
/// A point in the camera's plane (p_Cj.z = 0) gives a residual that is not finite; algorithms reject such a step. One behind
/// a camera is projected through its center as if it were ahead; InDomain tells. The host's point counts as exact: where its
/// noise matters, as for covariances, take edge_track.h.

#include "ch5_backend/graph/fast_edge.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/visual/point_transfer.h"

namespace ch5 {

/// Inverse-depth landmark, host pose i, target pose j; the extrinsic T_B_C is a constant.
class EdgeReprojection : public SizedEdge<2, VertexInverseDepth, VertexPose, VertexPose>, public FastEdge {
 public:
  /// @param u_host, u_target  observations [x, y] on the normalized plane of the host and the target
  /// @param T_B_C  [m], its quaternion normalized here; @throws std::invalid_argument if that is zero or not finite
  EdgeReprojection(std::shared_ptr<VertexInverseDepth> inverse_depth, std::shared_ptr<VertexPose> T_W_Bi,
                   std::shared_ptr<VertexPose> T_W_Bj, const Vec2& u_host, const Vec2& u_target,
                   const Transform& T_B_C = {});
  void ComputeResidual() override;
  void ComputeJacobians() override { Linearize(); }
  void Linearize() override;
  std::unique_ptr<EdgeBatch> MakeBatch() const override;
  bool InDomain() const override;
  std::string TypeInfo() const override { return "EdgeReprojection"; }

 private:
  friend struct ReprojectionReader;  // of its batch
  PointTransfer ToTarget() const;

  Vec3 f_host_;  // [u, v, 1]
  Vec2 u_target_;
  RigidMatrix T_B_C_;
};

/// The same with the extrinsic T_B_C as a fourth vertex, to be refined or fixed.
class EdgeReprojectionExtrinsic : public SizedEdge<2, VertexInverseDepth, VertexPose, VertexPose, VertexPose> {
 public:
  EdgeReprojectionExtrinsic(std::shared_ptr<VertexInverseDepth> inverse_depth, std::shared_ptr<VertexPose> T_W_Bi,
                            std::shared_ptr<VertexPose> T_W_Bj, std::shared_ptr<VertexPose> T_B_C, const Vec2& u_host,
                            const Vec2& u_target);
  void ComputeResidual() override;
  void ComputeJacobians() override;
  bool InDomain() const override;
  std::string TypeInfo() const override { return "EdgeReprojectionExtrinsic"; }

 private:
  PointTransfer ToTarget(const RigidMatrix& T_B_C) const;

  Vec3 f_host_;
  Vec2 u_target_;
};

/// A 3-D point seen from a pose; the extrinsic is a constant.
class EdgeReprojectionXYZ : public SizedEdge<2, VertexPointXYZ, VertexPose> {
 public:
  EdgeReprojectionXYZ(std::shared_ptr<VertexPointXYZ> p_W, std::shared_ptr<VertexPose> T_W_B, const Vec2& u,
                      const Transform& T_B_C = {});
  void ComputeResidual() override;
  void ComputeJacobians() override { Linearize(); }
  void Linearize() override;
  bool InDomain() const override;
  std::string TypeInfo() const override { return "EdgeReprojectionXYZ"; }

 private:
  Vec2 u_;
  RigidMatrix T_B_C_;
};

/// A known point seen from a pose, as in tracking; the extrinsic is a constant.
class EdgeReprojectionPoseOnly : public SizedEdge<2, VertexPose> {
 public:
  EdgeReprojectionPoseOnly(std::shared_ptr<VertexPose> T_W_B, const Vec3& p_W, const Vec2& u,
                           const Transform& T_B_C = {});
  void ComputeResidual() override;
  void ComputeJacobians() override;
  bool InDomain() const override;
  std::string TypeInfo() const override { return "EdgeReprojectionPoseOnly"; }

 private:
  Vec3 p_W_;
  Vec2 u_;
  RigidMatrix T_B_C_;
};

}  // namespace ch5
