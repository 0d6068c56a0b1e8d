#pragma once
/// What an estimator and a batch begin with: the calibration, and the knowledge of the first state.

#include <memory>

#include "ch5_backend/marginalize/edge_prior.h"
#include "ch5_backend/window/estimator.h"

namespace ch5 {

/// Sets extrinsics and time offset to what the options give, fixed unless they are to be estimated.
void SetCalibration(const EstimatorOptions& options, Window* window);

/// Allowed change of the specific force at rest: a resting body sways and trembles [m/s²].
constexpr double kForceAtRestSigma = 0.05;

/// One prior of speed and biases of the oldest frame at its present state, and of the estimated part of the calibration.
/// Without the latter the first windows, with little motion, would let the extrinsic diverge.
/// @param speed          standard deviation [m/s]
/// @param knows_gravity  whether its tilt is known too, as gravity was measured at rest
std::shared_ptr<EdgePrior> StartPrior(const Window& window, double speed, const EstimatorOptions& options,
                                      bool knows_gravity = false);

}  // namespace ch5
