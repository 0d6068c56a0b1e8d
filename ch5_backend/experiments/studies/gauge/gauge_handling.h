#pragma once
/// Three ways to handle the free gauge of a graph with an IMU, which is position and yaw:
///
///   fixation   optimizer.Hold({HoldGauge(first)});                            n − 4 unknowns
///   prior      graph.AddEdge(std::make_shared<EdgeGaugePrior>(first, w));     n unknowns, the gauge held by a weight
///   free       nothing, as Levenberg-Marquardt's damping makes H regular; or Gauss-Newton with
///              optimizer.SetReducedSolver(MakePseudoInverse(4));              n unknowns, H of rank n − 4
///
/// The minimum of the cost is the same for all three: they choose another representative of the same solution.
/// Source: Zhang, Gallego, Scaramuzza, RA-L 2018, §IV.

#include "ch5_backend/consistency/gauge_freedom.h"
#include "ch5_backend/graph/ordering.h"
#include "ch5_backend/graph/sized_edge.h"
#include "ch5_backend/types/vertices.h"

namespace ch5 {

/// p and e_zᵀΔφ of the first pose stay at their initial values.
HeldDirections HoldGauge(const std::shared_ptr<VertexReferencePose>& first);

/// The prior of weight w on what HoldGauge holds:  r = [p − p⁰; e_zᵀΔφ],  W = w I₄  [1/m², 1/rad²].
class EdgeGaugePrior : public SizedEdge<4, VertexReferencePose> {
 public:
  EdgeGaugePrior(std::shared_ptr<VertexReferencePose> first, double weight);
  void ComputeResidual() override;
  void ComputeJacobians() override;
  std::string TypeInfo() const override { return "EdgeGaugePrior"; }
};

/// V of GaugeProjection: the held directions as columns, with rows in the order of the vertices.
MatXX HeldColumns(const Vertices& vertices, const HeldDirections& held);

}  // namespace ch5
