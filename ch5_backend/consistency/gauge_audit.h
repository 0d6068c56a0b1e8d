#pragma once
/// The gauge auditor: what no measurement can tell must not be in H.
///
/// Moving the whole world, vertices x ↦ g(ε)·x, changes no residual: position and yaw for visual-inertial problems
/// (gravity fixes roll and pitch, the accelerometer scale), position, rotation and scale for a camera alone. So for
/// each direction n = ∂(g(ε)·x ⊟ x)/∂ε, taken here by finite differences of the group's action on the vertices,
///
///   H n = 0   and   nᵀb = 0   at every linearisation, whatever has been marginalised before.
///
/// Where it is not so, the difference is information that leaked in: nᵀHn is what H claims to know.

#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

enum class GaugeGroup {
  kVisualInertial,  ///< x, y, z, yaw
  kMonocular        ///< x, y, z, roll, pitch, yaw, scale
};

/// What H knows of one direction of the gauge.
struct GaugeLeak {
  std::string direction;     ///< "x", "y", "z", "roll", "pitch", "yaw" (about W's axes) or "scale"
  double information = 0.0;  ///< nᵀHn for a motion by 1 m, 1 rad, or a factor e: 1/σ² of what H claims
  double relative = 0.0;     ///< ‖P⁻¹Hn‖/‖Pn‖, P = √diag(H): 0 for a null vector, free of units
  double gradient = 0.0;     ///< nᵀb
};

struct GaugeAuditOptions {
  GaugeGroup group = GaugeGroup::kVisualInertial;
  std::vector<const Vertex*> bystanders;   ///< poses that do not live in W, such as an extrinsic
  const Prior* first_estimates = nullptr;  ///< where EdgeFirstEstimate linearises; n is taken there too
};

/// Linearises the edges at the present states and tries each direction of the gauge. Fixed vertices do not move: they
/// hold a gauge, and that shows. Rotations and scale are about the mean position of the poses.
/// @param edges  at least one; H is dense, so a window and not a city
std::vector<GaugeLeak> AuditGauge(const std::vector<std::shared_ptr<Edge>>& edges,
                                  const GaugeAuditOptions& options = {});

/// The same for a prior alone, at its first estimates: what has leaked into it in its life so far.
std::vector<GaugeLeak> AuditPrior(const Prior& prior, const GaugeAuditOptions& options = {});

/// The directions n as columns, over the vertices in the given order.
MatXX GaugeDirections(const std::vector<std::shared_ptr<Vertex>>& vertices, const GaugeAuditOptions& options);

}  // namespace ch5
