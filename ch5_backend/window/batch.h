#pragma once
/// A whole recording as one least-squares problem: the window that nothing ever leaves.
///
///   frames      f₀ ──IMU── f₁ ──IMU── … ──IMU── f_n      every image with its pose, speed and biases
///   landmarks      ╲____╲____╱                           every track, with all its observations
///
/// Nothing is marginalized, so nothing is linearized at a state that has since moved: what a window loses by
/// marginalizing is its distance from this solution (Triggs et al., "Bundle Adjustment — A Modern Synthesis", 2000).

#include <vector>

#include "ch5_backend/window/estimator.h"

namespace ch5 {

struct BatchOptions {
  int rounds = 4;  ///< solves; between them outliers leave, and the IMU is integrated again at the biases found
  int max_iterations = 12;  ///< of a solve
  double cost_tolerance = 1e-6;
  int threads = 1;
  std::function<void(const Window&)> watch = nullptr;  ///< called with the window that was solved
};

/// What one solve of all images has found.
struct BatchResult {
  std::vector<StampedState> states;  ///< one per image
  Transform T_B_C;                   ///< as estimated
  std::optional<Transform> T_B_C1;   ///< that of camera 1, if there is one
  double time_offset = 0.0;          ///< likewise [s]
  int landmarks = 0, observations = 0;
  Summary solve;  ///< of the last round; its seconds are those of all
};

/// Solves for all images at once, with the weights, the calibration and the prior of an estimator's start.
/// @param images  consecutive, each within `weights.max_imu_seconds` of the one before
/// @param start   an estimator's state of each image, of one segment
/// @param imu     of the recording, over all images
/// @throws OptionError if an option is out of its range
/// @throws std::invalid_argument unless there are two images or more and as many states
BatchResult SolveBatch(const EstimatorOptions& options, const std::vector<Image>& images,
                       const std::vector<StampedState>& start, const std::vector<ImuMeasurement>& imu,
                       const BatchOptions& batch = {});

}  // namespace ch5
