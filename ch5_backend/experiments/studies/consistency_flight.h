#pragma once
/// The flights on which the estimators' covariances are compared with their errors, and the estimators that fly them.

#include <cmath>
#include <memory>
#include <string>

#include "ch5_backend/experiments/studies/odometry.h"

namespace ch5 {

struct ConsistencyOptions {
  int runs = 50;
  double seconds = 20.0;
  int max_tracks = 24;
  double camera_rate = 5.0;     ///< [Hz]
  double heading = 0.5 * M_PI;  ///< from the radius: looks along the path; 0: outward [rad]
  int threads = 0;              ///< 0: as many as the machine has; the result does not depend on it
};

/// What varies between the estimators of the study.
struct ConsistencyCase {
  std::string policy;        ///< "vins", "okvis"
  std::string observations;  ///< "twice", VINS-Mono's re-use of what its prior contains, or "once"
  /// "exact", as in VINS-Mono and by default, or "noisy" (types/visual/edge_track.h), both with the true σ and no loss, so
  /// that nothing else makes a claim wrong; or "published": exact with VINS-Mono's σ and loss, the defaults of WindowWeights
  std::string hosts;
  std::string mode;  ///< ObservabilityConstraints: "none", "prior_only" (marginalized edges), "full" (all edges)
};

/// Circles in a room; runs differ in the noise of camera and IMU.
Recording ConsistencyFlight(const ConsistencyOptions& options, int run);

/// A first state drawn around the truth, and what is known of it: the σ of the draw.
struct DrawnStart {
  StampedState state;
  MatXX J;       ///< square root of its information over [δp, δθ, v, b_a, b_g]
  MatXX J_free;  ///< the same without position and yaw
};
DrawnStart DrawStart(const StampedState& truth, int run);

/// The settings of one case, and its policy with a small window.
EstimatorOptions ConsistencyEstimator(const ConsistencyCase& c, const Calibration& calibration);
std::unique_ptr<WindowPolicy> ConsistencyPolicy(const ConsistencyCase& c);

}  // namespace ch5
