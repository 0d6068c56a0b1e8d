#pragma once
/// Three ways to handle a free gauge, for any graph:
///
///   fixation   optimizer.Hold(HoldGauge(first));                              n − 4 unknowns (n − 7 without an IMU)
///   prior      graph.AddEdge(std::make_shared<EdgeGaugePrior>(first, w));     n unknowns, the gauge held by a weight
///   free       nothing, as Levenberg-Marquardt's damping makes H regular; or Gauss-Newton with
///              optimizer.SetReducedSolver(MakePseudoInverse(4));              n unknowns, H of rank n − 4
///
/// The minimum of the cost is the same for all three: they choose another representative of the same solution.
/// Source: Zhang, Gallego, Scaramuzza, RA-L 2018, §IV.

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/sparse/covariance.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

/// With an IMU: p and e_zᵀΔφ of the first pose stay at their initial values.
std::vector<HeldDirections> HoldGauge(const std::shared_ptr<VertexReferencePose>& first);

/// A camera alone: all of the first pose stays, and what the second one's position is along their present baseline.
/// @throws std::invalid_argument if there is no baseline
std::vector<HeldDirections> HoldGauge(const std::shared_ptr<VertexReferencePose>& first,
                                      const std::shared_ptr<VertexPose>& second);

/// The prior of weight w on what the first HoldGauge holds:  r = [p − p⁰; e_zᵀΔφ],  W = w I₄  [1/m², 1/rad²].
class EdgeGaugePrior : public SizedEdge<4, VertexReferencePose> {
 public:
  EdgeGaugePrior(std::shared_ptr<VertexReferencePose> first, double weight);
  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return "EdgeGaugePrior"; }
};

/// V of GaugeProjection: the held directions as columns, with rows in the order of the vertices.
MatXX HeldColumns(const Vertices& vertices, const std::vector<HeldDirections>& held);

/// Covariances in another gauge out of a sparse solver's marginals, at the same states, without a dense Σ:
///
///   Σ'_ab = Σ_ab − U_a G (ΣV)_bᵀ − (ΣV)_a Gᵀ U_bᵀ + U_a G (VᵀΣV) Gᵀ U_bᵀ,   G = (VᵀU)⁻¹       from Q Σ Qᵀ
class GaugeCovariance {
 public:
  /// @param covariance  with the gauge held in any way; it must outlive this
  /// @param held        the gauge that is wanted; none: the free one of the pseudo-inverse, V = U
  /// @throws std::invalid_argument if `held` does not hold the gauge
  GaugeCovariance(Covariance* covariance, GaugeGroup group, const std::vector<HeldDirections>& held = {});
  /// As Covariance::Block.
  MatXX Block(const Vertex& a, const Vertex& b);

 private:
  Covariance* covariance_;
  MatXX UG_, SV_, B_;  // U G, ΣV and VᵀΣV
};

}  // namespace ch5
