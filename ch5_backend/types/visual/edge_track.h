#pragma once
/// All views of one landmark as one residual, the host's point counting as a measurement like the others.
///
///   r = [r_1; …; r_m],  r_j of EdgeReprojection:   r_j = B_j n_h − n_j,  B_j = ∂r_j/∂u_host
///   cov r = σ² (I + B Bᵀ),   W = σ⁻² (I − B (I + BᵀB)⁻¹ Bᵀ)
///
/// One EdgeReprojection a view treats the host's point as exact, though its noise n_h is in every residual of the
/// landmark: with many views it is certain of too much. Here n_h is eliminated, which is the same as estimating the
/// host's bearing beside the inverse depth.

#include "ch5_backend/types/visual/edge_reprojection.h"

namespace ch5 {

class EdgeTrack : public Edge {
 public:
  /// One observation of the track.
  struct View {
    std::shared_ptr<VertexPose> T_W_B;
    Vec2 x;  ///< normalized plane
  };
  /// W is that of the present states.
  /// @param views  the host's first, at least two;  @param sigma  of all points [normalized plane]
  /// @throws std::invalid_argument unless there are two views, σ > 0, and no vertex is null
  EdgeTrack(const std::shared_ptr<VertexInverseDepth>& inverse_depth, const std::vector<View>& views,
            const Transform& T_B_C, double sigma);
  void ComputeResidual() override;
  void ComputeJacobians() override { Linearize(); }
  void Linearize() override;
  bool InDomain() const override;
  std::string TypeInfo() const override { return "EdgeTrack"; }

 private:
  std::vector<std::unique_ptr<EdgeReprojection>> views_;
  VecX r_;
  MatXX W_;
  std::vector<MatXX> J_;  // inverse depth, host, targets
};

}  // namespace ch5
