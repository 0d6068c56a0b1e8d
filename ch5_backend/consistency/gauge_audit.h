#pragma once
/// The gauge auditor: what no measurement observes must not be in H.
///
/// Moving the whole world changes no residual (gauge_directions.h). So for every direction n of the gauge
///
///   H n = 0   and   nᵀb = 0   at every linearization, whatever has been marginalized before.
///
/// Where this fails, the difference is spurious information: nᵀHn is what H claims to know of n.
///
/// This folder, `consistency/`, asks whether an estimator is as certain as it may be. In: edges, priors, estimates with
/// their covariances. Out: spurious information along the gauge, edges with corrected Jacobians, NEES with its bounds.
/// Reading order: gauge_directions.h, this file, gauge_freedom.h, observability.h.

#include "ch5_backend/consistency/gauge_directions.h"
#include "ch5_backend/marginalize/edge_prior.h"

namespace ch5 {

/// What H claims to know along one direction of the gauge.
struct GaugeLeak {
  std::string direction;     ///< "x", "y", "z", "roll", "pitch", "yaw" (about W's axes) or "scale"
  double information = 0.0;  ///< nᵀHn for a motion by 1 m, 1 rad, or a factor e: 1/σ² of what H claims
  double relative = 0.0;     ///< ‖P⁻¹Hn‖/‖Pn‖, P = √diag(H): 0 for a null vector, independent of units
  double gradient = 0.0;     ///< nᵀb
};

/// Linearizes the edges at the present states and tests each direction of the gauge. A fixed vertex does not move, so it
/// fixes the gauge, and that shows as a leak.
/// @param edges  at least one; H is dense, so use it on a window, not on a large map
std::vector<GaugeLeak> AuditGauge(const std::vector<std::shared_ptr<Edge>>& edges, const GaugeOptions& options = {});

/// The same for a prior alone, at its first estimates: all that has leaked into it since the first marginalization.
std::vector<GaugeLeak> AuditPrior(const Prior& prior, const GaugeOptions& options = {});

}  // namespace ch5
