#pragma once
/// The observation of a "Bundle Adjustment in the Large" problem (Agarwal et al., ECCV 2010), in pixels, y up:
///   P = Exp(ω) X + t,   p = −[P.x, P.y]/P.z,   u = f (1 + k1‖p‖² + k2‖p‖⁴) p,   r = u − measurement.

#include "ch5_backend/graph/fast_edge.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

class EdgeBAL : public SizedEdge<2, VertexCameraBAL, VertexPointXYZ>, public FastEdge {
 public:
  EdgeBAL(std::shared_ptr<VertexCameraBAL> camera, std::shared_ptr<VertexPointXYZ> p_W, const Vec2& pixel)
      : SizedEdge(std::move(camera), std::move(p_W)), pixel_(pixel) {}
  void ComputeResidual() override;
  void ComputeJacobians() override { Linearize(); }
  void Linearize() override;
  std::unique_ptr<EdgeBatch> MakeBatch() const override;
  /// P.z < 0: this camera looks along its −z axis.
  bool InDomain() const override;
  const Vec2& Pixel() const { return pixel_; }
  std::string TypeInfo() const override { return "EdgeBAL"; }

 private:
  Vec2 pixel_;
};

}  // namespace ch5
