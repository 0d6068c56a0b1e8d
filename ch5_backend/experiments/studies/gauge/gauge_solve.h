#pragma once
/// One solve of the gauge paper's problem: a way to handle the gauge, and what came of it.

#include "ch5_backend/evaluate/trajectory_error.h"
#include "ch5_backend/experiments/studies/gauge/gauge_handling.h"
#include "ch5_backend/simulate/sensors/visual_inertial_ba.h"
#include "ch5_backend/sparse/sparse_optimizer.h"

namespace ch5 {

enum class GaugeHandling {
  kFixation,       ///< HoldGauge
  kPrior,          ///< a prior, see PriorPlace
  kFree,           ///< Levenberg-Marquardt's damping alone
  kPseudoInverse,  ///< free, Gauss-Newton with S⁺
};

/// What a prior holds, at its initial value.
enum class PriorPlace {
  kGauge,          ///< p₀ and Δφ₀z: 4 constraints for 4 freedoms, the paper's
  kFirstPose,      ///< all of pose 0: 6
  kFirstTwoPoses,  ///< poses 0 and 1: 12, the course's
};

struct GaugeMethod {
  GaugeHandling handling = GaugeHandling::kFree;
  double weight = 0.0;  ///< of a prior [1/m², 1/rad²]; 0: none
  PriorPlace place = PriorPlace::kGauge;
};

/// Levenberg-Marquardt with λ diag(H), λ₀ = 1e-4, until the cost falls by less than 1e-6 of itself: Ceres' defaults,
/// which the paper used.
struct GaugeSettings {
  GaugeSettings();
  Damping damping = Damping::kDiagonal;
  SolveOptions solve;
};

struct GaugeRun {
  Summary summary;
  double milliseconds = 0.0;  ///< processor time of the solve
  TrajectoryError error;      ///< aligned at the first pose in position and yaw
  std::vector<double>
      reprojection_px;  ///< √(mean ‖r‖²) of the observations at the start and after each iteration [px] …
  std::vector<double> prior_error;  ///< … and ‖r‖ of the priors [m, rad]
};

/// The hold of all biases, which the problem knows.
std::vector<HeldDirections> HoldBiases(const VisualInertialBa& problem);

/// Adds the method's priors and tells the optimizer what to hold.
void HandleGauge(const VisualInertialScene& scene, const GaugeMethod& method, VisualInertialBa* problem,
                 SparseOptimizer* optimizer);

/// The problem solved to the end, and Σ = H⁺ of all its unknowns, zero along what is held.
struct GaugeSolution {
  VisualInertialBa problem;
  std::vector<HeldDirections> held;
  Vertices vertices;  ///< in the order of Σ's rows: pose and speed of each keyframe, then the points
  Summary summary;
  MatXX covariance;
};
/// @param handling  kFixation or kFree
GaugeSolution SolveForCovariance(const VisualInertialScene& scene, GaugeHandling handling);

/// Where their rows are in H.
std::vector<int> RowsInHessian(const Vertices& vertices);

/// Builds the scene and solves it.
GaugeRun SolveGauge(const VisualInertialScene& scene, const GaugeMethod& method, const GaugeSettings& settings = {});

}  // namespace ch5
